"""What is looked at while a fit goes on, to be drawn beside its loss."""

from typing import ClassVar, Protocol

import numpy as np
from torch import Tensor


class Watch(Protocol):
    """A number of each member that an optimiser asks for: at `always` every step, else now and then."""

    name: ClassVar[str]
    always: ClassVar[bool]

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """The number (member,) at the weights (member, n_parameters) of a step."""

    def member(self, index: int) -> "Watch":
        """The same for one member alone."""
