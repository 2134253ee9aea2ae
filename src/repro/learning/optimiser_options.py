"""What every kind of optimiser declares: its options, and how they change from phase to phase."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self

from repro.plugins.options import Count, Natural, NotNegative, PluginOptions, Positive

OPTIMISERS = "learning.optimisers"  # the folder of these choices


@dataclass(frozen=True)
class OptimiserOptions(PluginOptions):
    """Options of an optimiser; a file of learning/optimisers extends it and has `build(options)`.

    unit            what it counts, if anything
    linear_only     it needs a model that is linear in its parameters, and the inverse equation
    selects         it drops terms of a basis
    linearises      it needs the Jacobian of the rows
    handles_l1      it minimises the l1 terms of (7a)
    runs_on_device  it runs on a device other than the CPU
    name            of the file in conf/optimiser; changes no result
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = None
    linear_only: ClassVar[bool] = False
    selects: ClassVar[bool] = False
    linearises: ClassVar[bool] = False
    handles_l1: ClassVar[bool] = False
    runs_on_device: ClassVar[bool] = False

    name: str = field(default="", kw_only=True)

    @property
    def length(self) -> int:
        """Epochs or iterations, at most; 0 for a closed form."""
        return 0

    def lasting(self, epochs: int) -> Self:
        """The same for so many epochs, where it counts in epochs."""
        return self

    @property
    def cut_by(self) -> str | None:
        """Name of the option that `shortened` cuts: the budget where there is one, else epochs or iterations."""
        return self.unit if getattr(self, "budget_s", None) is None else "budget_s"

    def shortened(self, share: float) -> Self:
        """The same for a share of what `cut_by` names: of the CPU seconds, or of epochs or iterations, rounded up."""
        if self.cut_by is None:
            return self
        whole = getattr(self, self.cut_by)
        cut: dict[str, Any] = {self.cut_by: whole * share if self.cut_by == "budget_s" else math.ceil(whole * share)}
        return replace(self, **cut)

    def continued(self) -> Self:
        """The same for a later phase, which starts from weights that are already good."""
        return self


@dataclass(frozen=True)
class FullBatchOptions(OptimiserOptions):
    """At most `iterations` on the same `samples` random training samples of each member; None: on all.

    budget_s: CPU seconds of a member, looked at after every iteration.
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = "iterations"

    iterations: Natural = 100
    samples: Count | None = None
    budget_s: Positive | None = None

    @property
    def length(self) -> int:
        """Iterations, at most."""
        return self.iterations


@dataclass(frozen=True)
class AdamOptions(OptimiserOptions):
    """Options of optimiser=adam and adam_cosine.

    rule `sgd`: plain gradient descent on the same batches, without moments, momentum or epsilon.
    schedule `keras`: learning rate / (1 + decay k) at step k; `cosine`: down to 1e-4 of it along half a cosine. engine
    `auto`: compiled code where a compiler and a kernel for model and precision exist, else torch. precision: Keras's
    default is float32, which only networks of features have a kernel for. budget_s: CPU seconds of a member, looked at
    after every epoch; the cosine then falls along the share of it that is spent, and `epochs` are the most.
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = "epochs"
    handles_l1: ClassVar[bool] = True
    runs_on_device: ClassVar[bool] = True

    epochs: Count = 1000
    learning_rate: NotNegative = 0.01
    decay: NotNegative = 1e-6
    rule: Literal["adam", "sgd"] = "adam"
    schedule: Literal["keras", "cosine"] = "keras"
    batch_size: Count = 2048
    epsilon: Positive = 1e-7
    curve_points: Count = 200
    engine: Literal["auto", "torch"] = "auto"
    precision: Literal["float64", "float32"] = "float64"
    budget_s: Positive | None = None

    @property
    def length(self) -> int:
        """Epochs."""
        return self.epochs

    def lasting(self, epochs: int) -> Self:
        """The same for so many epochs."""
        return replace(self, epochs=epochs)


@dataclass(frozen=True)
class SelectionOptions(OptimiserOptions):
    """Options of optimiser=thresholded_least_squares and lasso.

    threshold: share of the signal that a term must carry (method `thresholded`). penalty: weight of the absolute
    coefficients, and refit: by least squares on the terms that remain (method `lasso`).
    """

    linear_only: ClassVar[bool] = True
    selects: ClassVar[bool] = True

    method: Literal["thresholded", "lasso"] = "thresholded"
    threshold: NotNegative = 0.05
    penalty: NotNegative = 1e-2
    refit: bool = True


@dataclass(frozen=True)
class LBFGSOptions(FullBatchOptions):
    """Options of optimiser=lbfgs; memory: pairs that the Hessian is made of."""

    iterations: Count = 1000
    samples: Count | None = 6000
    memory: Count = 30


@dataclass(frozen=True)
class LeastSquaresOptions(OptimiserOptions):
    """Options of optimiser=least_squares.

    cutoff: singular values below this share of the largest count as zero. regularise_towards: where the directions stay
    that the data do not determine.
    """

    linear_only: ClassVar[bool] = True

    cutoff: NotNegative = 1e-8
    regularise_towards: Literal["zero", "start"] = "zero"

    def continued(self) -> Self:
        """What the data of a later phase do not determine stays as the phases before have left it."""
        return replace(self, regularise_towards="start")


@dataclass(frozen=True)
class LevenbergMarquardtOptions(FullBatchOptions):
    """Options of optimiser=levenberg_marquardt.

    damping: at the start, divided by `damping_decrease` after a success (3 suits free-form networks, 10 models that
    contain the truth). tolerance: a step that gains less than this share of the loss counts as stalled. restarts:
    random starts, tried for `trial_iterations` each; the one with the lowest training loss goes on.
    """

    linearises: ClassVar[bool] = True

    iterations: Count = 300
    samples: Count | None = 3000
    damping: NotNegative = 1.0
    damping_decrease: Positive = 3.0
    tolerance: NotNegative = 1e-10
    restarts: Count = 8
    trial_iterations: Count = 40

    def shortened(self, share: float) -> Self:
        """The same for a share of the iterations, those of the trials too, or of the budget."""
        trial = self.trial_iterations if self.budget_s else math.ceil(share * self.trial_iterations)
        return replace(super().shortened(share), trial_iterations=trial)

    def continued(self) -> Self:
        """A later phase starts from the weights of the one before."""
        return replace(self, restarts=1)
