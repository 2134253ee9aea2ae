"""What every objective declares: its options, the rows that it minimises, and what it needs of model and data."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, ClassVar

import casadi
from annotated_types import Ge, Le

from repro.codegen.lazy_torch import Tensor
from repro.learning.symbolic import Symbols
from repro.models.model import Model
from repro.models.terms import Terms
from repro.plugins.options import Natural, NotNegative, PluginOptions, Positive

if TYPE_CHECKING:
    from repro.data.dataset import Dataset
    from repro.learning.objective import Objective
    from repro.learning.result import Fitted, Progress, Weights
    from repro.learning.training_problem import TrainingTask

OBJECTIVES = "learning.objectives"  # the folder of these choices


class EnergyForm(StrEnum):
    """What is compared with a known energy: p.qd - L, or T + V as printed."""

    LEGENDRE = "legendre"
    SUM = "sum"


@dataclass(frozen=True)
class ObjectiveOptions(PluginOptions):
    """Options of an objective (see conf/objective/_base.yaml); a file of learning/objectives has them and `rows`."""

    symbolic: ClassVar[bool] = (
        False  # it has `expression` too, of which kernels are compiled; otherwise torch computes it
    )
    linear: ClassVar[bool] = False  # its rows are linear in the coefficients of a linear basis
    needs_energies: ClassVar[bool] = True  # models that predict accelerations only cannot be fitted
    needs_mass: ClassVar[bool] = False  # `rows` reads the mass matrix
    needs_port_form: ClassVar[bool] = False  # it has both rows of eq. (12b)
    needs_force: ClassVar[bool] = True  # without a force L = 0 minimises it
    needs_accelerations: ClassVar[bool] = True  # otherwise motion is recorded, not accelerations
    needs_differentiable: ClassVar[bool] = False  # it integrates the model's acceleration
    needs_implicit_form: ClassVar[bool] = False  # the model has an equation of its own that is linear in its weights
    linearised: ClassVar[bool] = True  # its rows have Jacobians, as Gauss-Newton needs

    momentum_weight: NotNegative = 0.0
    l1_kinetic: NotNegative = 0.0
    l1_potential: NotNegative = 0.0
    error_scale: Positive | None = None
    equal_weight_share: Annotated[float, Ge(0), Le(1)] = 0.0
    passivity_states: Natural = 0

    @property
    def is_likelihood(self) -> bool:
        """Whether weights and motion are fitted together, to what sensors recorded."""
        return False

    @property
    def expects_unit_cost(self) -> bool:
        """Whether a good fit has a cost per degree of freedom of 1."""
        return False

    def rows(self, terms: Terms, measured: dict[str, Tensor]) -> Tensor:
        """Residual rows (member, sample, row); measured: qd, qdd, tau (member, sample, n_q)."""
        raise NotImplementedError

    def expression(self, model: Model, s: Symbols) -> casadi.SX:
        """The same rows (row,) of one sample as a CasADi expression, where the objective is symbolic."""
        raise NotImplementedError

    def task(self, model: Model, dataset: Dataset, minimised: Objective) -> TrainingTask:
        """What is minimised on a dataset."""
        from repro.learning.training import make_task

        return make_task(model, dataset, minimised, self.error_scale)

    def finished(self, model: Model, dataset: Dataset, fitted: Fitted, initial: Weights, progress: Progress) -> Fitted:
        """What follows the last phase of the optimiser; dataset: its training part, initial: weights before it."""
        return fitted
