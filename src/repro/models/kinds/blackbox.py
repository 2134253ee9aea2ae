"""A structure-free baseline: qdd = N(qd, cos q, sin q, tau)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.models.context import Context
from repro.models.features import FeatureMap
from repro.models.model import Model, Prepared
from repro.models.model_options import Activation, ModelOptions
from repro.models.network import Network
from repro.models.position import PositionFeatures, cart_with_links
from repro.models.terms import Terms
from repro.plugins.options import Count


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=blackbox; hidden: units of each hidden layer."""

    energetic: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    runs_on_device: ClassVar[bool] = True
    differentiable: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (32, 32)
    activation: Activation = "softplus"


class BlackBox(Model):
    """A network for the acceleration; it has no energies, no momenta and no inverse model."""

    inverse = False
    energetic = False

    def __init__(self, n_q: int, options: Options, positions: PositionFeatures | None = None) -> None:
        self.n_q = n_q
        self.positions = positions or cart_with_links(n_q)
        self.features = FeatureMap(self.positions.inertia, n_q)
        self.network = Network(2 * n_q + len(self.features), options.hidden, n_q, options.activation)
        self.n_parameters = self.network.n_parameters
        self.network_slice = slice(0, self.n_parameters)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights, zero biases."""
        return self.network.initial(generators)

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """The inputs as one-row jets (..., 1, n_in)."""
        features = self.features.jets(q, qd, qdd)[..., 0, :]
        return {"inputs": np.concatenate([qd, features, tau], axis=-1)[..., None, :]}

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """The accelerations as one-row jets (..., 1, n_q)."""
        return [self.network.propagate(parameters, prepared["inputs"])]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """Only the acceleration is defined."""
        return Terms(acceleration=outputs[0][..., 0, :])

    def acceleration_at(self, parameters: Tensor, q: Tensor, qd: Tensor, tau: Tensor) -> Tensor:
        """qdd (member, sample, n_q), differentiable in all arguments."""
        return self.network.values(parameters, torch.cat([qd, self.positions.values(q), tau], dim=-1))

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        return self.network.jacobian(parameters, prepared["inputs"], cotangents[0])

    def acceleration(self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """qdd as a CasADi expression."""
        z = casadi.vertcat(qd, self.features.expression(q, qd), tau)
        return self.network.expression(parameters, z)


def build(context: Context, options: Options) -> Model:
    """The network."""
    return BlackBox(context.n_q, options, context.positions)
