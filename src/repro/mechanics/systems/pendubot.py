"""Two rods on a fixed hinge, driven at the shoulder alone."""

from dataclasses import dataclass
from typing import ClassVar

from repro.mechanics.two_links import TwoLinks


@dataclass(frozen=True)
class Pendubot(TwoLinks):
    """The torque at the shoulder turns the first rod."""

    name: ClassVar[str] = "pendubot"
    driven: ClassVar[int] = 0
