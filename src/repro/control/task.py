"""The task of closed loops: starts, targets, the disc to avoid, and the disturbances (conf/task)."""

from dataclasses import dataclass
from typing import Annotated, Literal, assert_never

from annotated_types import Ge, Le, Len

from repro.control.conditions import Conditions, Start, hanging_start, random_start
from repro.control.geometry import Disc
from repro.mechanics.system import System
from repro.plugins.options import Count, Natural, NotNegative

# m: V-A (one link), V-B (two links)
RADIUS_ONE_LINK, RADIUS_MORE_LINKS = 0.3, 0.1


@dataclass(frozen=True, kw_only=True)
class Task(Conditions):
    """Options of conf/task, with the disturbances of `Conditions`.

    name            of its file in conf/task
    start           hanging at rest (one loop per seed and target), or random starts around it (the seeds in turn)
    initial_states  number of random starts
    x_des           targets of the cart, m
    seconds         length of a loop
    centre, radius  of the disc, m; radius None is the paper's for the number of links, 0 is no disc
    """

    name: str
    start: Literal["hanging", "random"]
    initial_states: Count
    start_seed: Natural
    x_des: Annotated[tuple[float, ...], Len(1)]
    seconds: Annotated[float, Ge(2), Le(1000)]
    centre: tuple[float, float]
    radius: NotNegative | None

    def disc(self, system: System) -> Disc | None:
        """The disc to avoid."""
        paper = RADIUS_ONE_LINK if len(system.angles) == 1 else RADIUS_MORE_LINKS
        radius = paper if self.radius is None else self.radius
        return Disc(self.centre, radius) if radius else None

    def n_loops(self, n_members: int) -> int:
        """Number of closed loops of an ensemble."""
        match self.start:
            case "hanging":
                return len(self.x_des) * n_members
            case "random":
                return self.initial_states
            case other:
                assert_never(other)

    def starts(self, system: System, n_members: int) -> list[tuple[Start, int]]:
        """The start of every loop, and the index of the member that drives it."""
        match self.start:
            case "hanging":
                return [(hanging_start(system, x), member) for x in self.x_des for member in range(n_members)]
            case "random":
                targets = [float(self.x_des[k % len(self.x_des)]) for k in range(self.initial_states)]
                starts = [random_start(system, x, self.start_seed, k) for k, x in enumerate(targets)]
                return [(start, k % n_members) for k, start in enumerate(starts)]
            case other:
                assert_never(other)
