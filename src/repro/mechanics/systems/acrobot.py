"""Two rods on a fixed hinge, driven at the elbow alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Input
from repro.mechanics.two_links import TwoLinks


@dataclass(frozen=True)
class Acrobot(TwoLinks):
    """The torque at the elbow turns the second rod one way and the first one the other."""

    name: ClassVar[str] = "acrobot"
    driven: ClassVar[int] = 1
    inputs = (Input("torque", "N m", 1.0),)

    def input_map(self, q: Sequence[Any], m: Any) -> Sequence[Sequence[Any]]:
        """It acts between the two rods."""
        return [[-1.0], [1.0]]
