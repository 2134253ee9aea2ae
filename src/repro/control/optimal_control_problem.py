"""The optimal control problem (9): costs, obstacle and limits over a horizon."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from repro.control.geometry import Disc
from repro.plugins.options import NotNegative, Options

AngleError = Literal["cosine", "square"]
PotentialGoal = Literal["maximum", "minimum", "goal"]
Discretisation = Literal["shooting", "collocation"]
SolverName = Literal["fatrop", "ipopt"]


@dataclass(frozen=True)
class NodeWeights(Options):
    """The cost of one node of the horizon as weights of its terms.

    kinetic T + potential V_cost + position |q_i - goal|^2 + angle sum_j e(theta_j - goal) + rates |qd|^2
    + force |u - u_goal|^2, where V_cost and e are those of the problem, and u_goal holds the model at rest at the goal.
    `position` counts for translations and cyclic coordinates, `angle` for all other angles. `position` and `force` may
    be weights by name, of coordinates and of inputs, the others then having none.
    """

    kinetic: NotNegative = 0.0
    potential: NotNegative = 0.0
    position: NotNegative | Mapping[str, NotNegative] = 0.0
    angle: NotNegative = 0.0
    rates: NotNegative = 0.0
    force: NotNegative | Mapping[str, NotNegative] = 0.0


def by_name(weight: float | Mapping[str, float], names: Sequence[str], counts: Sequence[bool]) -> list[float]:
    """The weight of each name: the same for all that count, or those given by name."""
    if isinstance(weight, Mapping):
        return [weight.get(name, 0.0) for name in names]
    return [weight if counted else 0.0 for counted in counts]


@dataclass(frozen=True)
class Obstacle(Disc):
    """A disc as the controller avoids it: the centre stays d >= clearance_radii * radius away from every link.

    constraint  d is a constraint of the problem; otherwise weight * sum over links of max(0, clearance^2 - d^2)^2 is a
                cost
    midpoints   both hold at every node but the first; whether at the middle of every interval too
    """

    clearance_radii: float = 1.05
    constraint: bool = False
    weight: float = 1e6
    midpoints: bool = False

    @property
    def clearance_squared(self) -> float:
        """The least squared distance to the centre, m^2."""
        return (self.clearance_radii * self.radius) ** 2


@dataclass(frozen=True)
class OptimalControlProblem:
    """Problem (9) over intervals whose lengths, s, may differ; the first is the sampling time of the controller.

    The stage cost of node k counts with the length of its interval over that of the first one.

    force_limit      of all inputs, or of each
    speed_limit      of velocities, m/s and rad/s
    potential_goal   V_cost: -V where the potential energy is to be greatest (V as printed in the printed reading), V
                     where least, (V - V(goal))^2, J^2, where it is to be that of the goal
    """

    intervals: tuple[float, ...]
    stage_cost: NodeWeights
    terminal_cost: NodeWeights
    obstacle: Obstacle | None = None
    force_limit: float | tuple[float, ...] = 4.0
    speed_limit: float | None = None
    angle_error: AngleError = "cosine"
    potential_goal: PotentialGoal = "maximum"

    @property
    def time_step(self) -> float:
        """Sampling time of the controller, s."""
        return self.intervals[0]
