"""Two rods on a fixed hinge, driven at the shoulder alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.inputs import Input
from repro.mechanics.two_links import TwoLinks


@dataclass(frozen=True)
class Pendubot(TwoLinks):
    """The torque at the shoulder turns the first rod."""

    name: ClassVar[str] = "pendubot"
    driven: ClassVar[int] = 0

    @property
    def inputs(self) -> tuple[Input, ...]:
        """A torque at the shoulder."""
        return (Input("torque", "N m", 1.0),)

    def input_map(self, q: Sequence[Any], m: Any) -> Sequence[Sequence[Any]]:
        """It acts on the first rod."""
        return [[1.0], [0.0]]
