"""Two rods on a fixed hinge, driven at the elbow alone."""

from dataclasses import dataclass
from typing import ClassVar

from repro.mechanics.two_links import TwoLinks


@dataclass(frozen=True)
class Acrobot(TwoLinks):
    """The torque at the elbow turns the second rod one way and the first one the other."""

    name: ClassVar[str] = "acrobot"
    driven: ClassVar[int] = 1
