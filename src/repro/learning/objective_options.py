"""Options of the loss."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated

from annotated_types import Ge, Le

from repro.learning.path.path_options import PathOptions
from repro.plugins.options import Natural, NotNegative, Options, Positive


class Equation(StrEnum):
    """Which equation of motion a model is fitted to: tau (PLNN), qdd (LNN), or both rows of eq. (12b).

    Without measured accelerations: the balance of momentum over windows, or the likelihood of the path itself.
    """

    INVERSE = "inverse"
    FORWARD = "forward"
    PORT = "port"
    BALANCE = "balance"
    PATH = "path"

    @property
    def begins_with_balance(self) -> bool:
        """Whether it is the balance of momentum that an optimiser fits."""
        return self in (Equation.BALANCE, Equation.PATH)


class EnergyForm(StrEnum):
    """What is compared with a known energy: p.qd - L, or T + V as printed."""

    LEGENDRE = "legendre"
    SUM = "sum"


@dataclass(frozen=True)
class ObjectiveOptions(Options):
    """Options of conf/objective.

    momentum_weight: of Omega_tran, eq. (8). l1_kinetic, l1_potential: lambda_T and lambda_V of (7a). error_scale s
    (m/s^2 and rad/s^2 together): each sample weighs 1 / (1 + |qdd|^2 / s^2). equal_weight_share: of the epochs or
    iterations, in a last phase with equal weights. passivity_states: random states at which passivity is checked on
    the way. window: s over which momentum is balanced. path: of objective=path, which starts from that balance.
    """

    kind: Equation = Equation.INVERSE
    momentum_weight: NotNegative = 0.0
    l1_kinetic: NotNegative = 0.0
    l1_potential: NotNegative = 0.0
    error_scale: Positive | None = None
    equal_weight_share: Annotated[float, Ge(0), Le(1)] = 0.0
    passivity_states: Natural = 0
    window: Positive = 0.2
    path: PathOptions = field(default_factory=PathOptions)
