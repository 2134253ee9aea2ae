"""What every kind of model declares: its options, and what can be done with it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.plugins.options import PluginOptions

if TYPE_CHECKING:
    from repro.mechanics.system import System

MODELS = "models.kinds"  # the folder of these choices
Activation = Literal["softplus", "tanh"]
Damping = Literal["none", "diagonal", "full", "gyroscopic", "coulomb", "offset"]
Factor = Literal["wide", "triangular"]
Initialisation = Literal["inertia", "glorot"]
Rod = Literal["part", "rigid_body", "mass"]
Structure = Literal["canonical", "free", "full"]
Dissipation = Literal["none", "constant", "state"]
NonNegative = Literal["softplus", "relu"]


@dataclass(frozen=True)
class ModelOptions(PluginOptions):
    """Options of a model; a file of models/kinds extends it and has `build(context, options)`."""

    fitted: ClassVar[bool] = True  # it has weights to fit; otherwise it is an anchor row
    energetic: ClassVar[bool] = True  # it has T and V; otherwise it predicts accelerations only
    controllable: ClassVar[bool] = True  # it has energies and an invertible mass matrix, as control needs
    from_true_system: ClassVar[bool] = False  # it is made from the true system, so it needs simulated data
    port_form: ClassVar[bool] = False  # it has both rows of eq. (12b)
    joinable: ClassVar[bool] = False  # copies of it, learned on one link, can be joined to a chain
    runs_on_device: ClassVar[bool] = False  # it is computed by torch from end to end
    differentiable: ClassVar[bool] = False  # its acceleration can be differentiated by the state, as `prediction` needs
    implicit_form: ClassVar[bool] = False  # it has an implicit equation that is linear in its weights
    has_coefficients: ClassVar[bool] = False  # on a linear basis, its weights are the coefficients of the basis alone

    @property
    def sub_models(self) -> tuple[str, ...]:
        """The trained sub-models that it is made of: its option `parts`, where it has one."""
        parts: tuple[str, ...] = getattr(self, "parts", ())
        return parts

    @property
    def uses_basis(self) -> bool:
        """Whether its energies are made of the features of conf/basis."""
        return self.has_coefficients

    @property
    def draws_coefficients(self) -> bool:
        """Whether its start is one of the coefficients of a linear basis."""
        return False

    @property
    def reads_spread(self) -> bool:
        """Whether it is built by the spread of its training data, so that other data make another model."""
        return True

    @property
    def has_momentum_transform(self) -> bool:
        """Whether it learns M_hat(q) of eq. (8), with an option `momentum_hidden`."""
        return getattr(self, "momentum_hidden", None) is not None

    @property
    def couples_rates(self) -> bool:
        """Whether it has forces that are linear in other rates and store no energy, as a motor has."""
        return getattr(self, "damping", "none") == "gyroscopic"

    def is_linear(self, basis_is_linear: bool) -> bool:
        """Whether tau is linear in what is fitted, on a basis that is linear or not."""
        return self.has_coefficients and basis_is_linear

    def problems(self) -> Iterator[str]:
        """Options that exclude each other, one line each."""
        yield from ()

    def system_problem(self, system: "System") -> str | None:
        """The reason why this true system cannot be modelled, or None."""
        if not system.is_coupled or not self.fitted or not self.energetic or self.couples_rates:
            return None
        return (
            f"model.kind = {self.kind!r}: system={system.name} has forces between its rates, as a motor has, which "
            "it cannot learn; use model=structured model.damping=gyroscopic, or model=port_hamiltonian "
            "model.structure=free"
        )

    def parts_problem(self, n_q: int, part_sizes: Sequence[int]) -> str | None:
        """The reason why sub-models of so many coordinates each cannot make up one of n_q, or None."""
        return None

    def device_problem(self) -> str | None:
        """The choice that keeps it from running on a device, or None."""
        return None if self.runs_on_device else f"model={self.kind}"
