"""The optimal control problem (9): costs, obstacle and limits over a horizon."""

from dataclasses import dataclass
from typing import Literal

from repro.control.geometry import Disc
from repro.plugins.options import NotNegative, Options

AngleError = Literal["cosine", "square"]
Discretisation = Literal["shooting", "collocation"]
SolverName = Literal["fatrop", "ipopt"]


@dataclass(frozen=True)
class NodeWeights(Options):
    """The cost of one node of the horizon as weights of its terms.

    kinetic T + potential V_cost + position (x - x_des)^2 + angle sum_j e(theta_j) + rates |qd|^2 + force f^2, where
    V_cost = -V in the physical reading and e is the angle error of the problem.
    """

    kinetic: NotNegative = 0.0
    potential: NotNegative = 0.0
    position: NotNegative = 0.0
    angle: NotNegative = 0.0
    rates: NotNegative = 0.0
    force: NotNegative = 0.0


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

    The stage cost of node k counts with the length of its interval over that of the first one. Limits: force in N,
    velocities in m/s and rad/s.
    """

    intervals: tuple[float, ...]
    stage_cost: NodeWeights
    terminal_cost: NodeWeights
    obstacle: Obstacle | None = None
    force_limit: float = 4.0
    speed_limit: float | None = None
    angle_error: AngleError = "cosine"

    @property
    def time_step(self) -> float:
        """Sampling time of the controller, s."""
        return self.intervals[0]
