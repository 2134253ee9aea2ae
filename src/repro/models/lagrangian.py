"""L = T - V with T linear in a basis or a network of it, and V linear in cosines: sections II and III-A."""

from collections.abc import Sequence
from types import ModuleType
from typing import Literal

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.models.features import FeatureMap
from repro.models.model import EnergyExpressions, Model, Prepared, consecutive
from repro.models.model_options import Activation
from repro.models.network import Network
from repro.models.position import PositionFeatures, cart_with_links
from repro.models.terms import Terms, symmetric

Start = Literal["glorot", "wide", "positive", "ones"]


class MomentumTransform:
    """M_hat(q) of p_tran = M_hat(q) qd, eq. (8): symmetric, its entries from a network on the position features."""

    def __init__(self, n_q: int, hidden: Sequence[int], positions: PositionFeatures) -> None:
        self.n_q, self.features = n_q, FeatureMap(positions.inertia, n_q)
        self.network = Network(len(self.features), tuple(hidden), n_q * (n_q + 1) // 2)
        self.n_parameters, self.initial = self.network.n_parameters, self.network.initial

    def expression(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """p_tran as a CasADi expression."""
        entries = self.network.expression(parameters, self.features.expression(q, qd))
        matrix = casadi.SX(self.n_q, self.n_q)
        for number, (row, column) in enumerate(self.features.mass_pairs):
            matrix[row, column] = matrix[column, row] = entries[number]
        return matrix @ qd


class Lagrangian(Model):
    """The paper's parameterisations (7): T = alpha . T_j or T = N(T_j); V = beta . V_j.

    parameters: [alpha or the weights of N | beta | weights of the momentum transform, when there is one].
    `input_scale` (n_features,) divides the first layer's starting weights: the same network, a start fit for the data.
    initialisation: coefficients of a linear T are draws as of a `glorot` layer, their sizes (`positive`), or `ones`.
    """

    def __init__(
        self,
        basis: ModuleType,
        n_q: int,
        *,
        hidden: Sequence[int] = (10,),
        activation: Activation = "softplus",
        input_scale: np.ndarray | None = None,
        momentum_hidden: Sequence[int] | None = None,
        positions: PositionFeatures | None = None,
        initialisation: Start = "glorot",
    ) -> None:
        self.n_q = n_q
        self.kinetic_features = FeatureMap(basis.kinetic, n_q)
        self.potential_features = FeatureMap(basis.potential, n_q)
        self.linear: bool = basis.LINEAR
        self.linear_in_weights = self.linear
        self.network = None if self.linear else Network(len(self.kinetic_features), tuple(hidden), 1, activation)
        self.input_scale, self.initialisation = input_scale, initialisation
        shown = positions or cart_with_links(n_q)
        self.transform = None if momentum_hidden is None else MomentumTransform(n_q, momentum_hidden, shown)
        n_kinetic = len(self.kinetic_features) if self.network is None else self.network.n_parameters
        sizes = n_kinetic, len(self.potential_features), self.transform.n_parameters if self.transform else 0
        self.kinetic_slice, self.potential_slice, self.transform_slice = consecutive(*sizes)
        self.n_parameters = sum(sizes)

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of alpha and beta, for a linear basis."""
        return (*self.kinetic_features.names, *self.potential_features.names)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform draws (a column vector of coefficients counts as a layer with one output)."""
        n_t, n_v = len(self.kinetic_features), len(self.potential_features)
        if self.network is None:
            kinetic = np.stack([_coefficients(n_t, g) for g in generators])
            if self.initialisation == "positive":
                kinetic = np.abs(kinetic)
            elif self.initialisation == "ones":
                kinetic = np.ones_like(kinetic)
        else:
            kinetic = self.network.initial(generators)
            if self.input_scale is not None:
                width = self.network.shapes[0][0] * n_t
                kinetic[:, :width] /= np.tile(self.input_scale, self.network.shapes[0][0])
        parts = [kinetic, np.stack([_coefficients(n_v, g) for g in generators])]
        if self.transform is not None:
            parts.append(self.transform.initial(generators))
        return np.concatenate(parts, axis=1)

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """Jets of the features: kinetic (..., 2 + 2 n_q + n_pairs, n_T), potential [z, w_c] (..., 1 + n_q, n_V)."""
        prepared = {"kinetic": self.kinetic_features.jets(q, qd, qdd), "qd": qd}
        prepared["potential"] = self.potential_features.potential_rows(q, qd, qdd)
        if self.transform is not None:
            prepared["transform"] = self.transform.features.jets(q, qd, qdd)[..., :1, :]
        return prepared

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """Stacks [T, Tdot, p, tau_T, M] (..., n_rows), [V, w] (..., 1 + n_q) and the entries of M_hat(q)."""
        weights = parameters[:, self.kinetic_slice]
        jets = prepared["kinetic"] if mass else prepared["kinetic"][:, :, : 2 + 2 * self.n_q]
        if self.network is None:
            kinetic = torch.einsum("mnji,mi->mnj", jets, weights)
        elif mass:
            kinetic = self.network.propagate(weights, jets, self._pairs(mass))[..., 0]
        else:
            kinetic = self._lie_stack(weights, jets)
        potential = torch.einsum("mnji,mi->mnj", prepared["potential"], parameters[:, self.potential_slice])
        outputs = [kinetic, potential]
        if self.transform is not None:
            outputs.append(self.transform.network.propagate(parameters[:, self.transform_slice], prepared["transform"]))
        return outputs

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """EnergyExpressions, momentum and the inverse model (7b)."""
        n_q = self.n_q
        kinetic, potential = outputs[0], outputs[1]
        transformed = None
        if self.transform is not None:
            matrix = symmetric(outputs[2][..., 0, :], n_q)
            transformed = torch.einsum("...ij,...j->...i", matrix, prepared["qd"])
        return Terms(
            tau=kinetic[..., 2 + n_q : 2 + 2 * n_q] - potential[..., 1:],
            momentum=kinetic[..., 2 : 2 + n_q],
            kinetic=kinetic[..., 0],
            potential=potential[..., 0],
            mass=symmetric(kinetic[..., 2 + 2 * n_q :], n_q) if kinetic.shape[-1] > 2 + 2 * n_q else None,
            transformed_momentum=transformed,
        )

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        n_rows = cotangents[0].shape[-1]
        jets = prepared["kinetic"][:, :, :n_rows]
        if self.network is None:
            kinetic = torch.einsum("mrnj,mnji->mrni", cotangents[0], jets)
        else:
            pairs = self._pairs(n_rows > 2 + 2 * self.n_q)
            weights = parameters[:, self.kinetic_slice]
            kinetic = self.network.jacobian(weights, jets, cotangents[0].unsqueeze(-1), pairs)
        gradients = kinetic.new_zeros((*kinetic.shape[:3], self.n_parameters))
        gradients[..., self.kinetic_slice] = kinetic
        gradients[..., self.potential_slice] = torch.einsum("mrnj,mnji->mrni", cotangents[1], prepared["potential"])
        if self.transform is not None:
            weights = parameters[:, self.transform_slice]
            rows = [row for row in range(kinetic.shape[1]) if cotangents[2][:, row].any()]  # those of Omega_tran
            of_rows = self.transform.network.jacobian(weights, prepared["transform"], cotangents[2][:, rows])
            gradients[:, rows, :, self.transform_slice] = of_rows
        return gradients

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T and V as CasADi expressions."""
        z = self.kinetic_features.expression(q, qd)
        weights = parameters[self.kinetic_slice]
        kinetic = casadi.dot(weights, z) if self.network is None else self.network.expression(weights, z)
        potential = casadi.SX(0)
        if len(self.potential_features):
            potential = casadi.dot(parameters[self.potential_slice], self.potential_features.expression(q, qd))
        return EnergyExpressions(kinetic, potential)

    def _lie_stack(self, weights: Tensor, jets: Tensor) -> Tensor:
        """[T, Tdot, p, tau_T] from one tangent and one pass back through the network, whatever n_q is."""
        assert self.network is not None
        z, zdot, u, w = torch.split(jets, [1, 1, self.n_q, self.n_q], dim=2)
        value, rate, gradient, gradient_rate = self.network.lie_gradient(weights, z[:, :, 0], zdot[:, :, 0])
        gradient, gradient_rate = gradient.unsqueeze(2), gradient_rate.unsqueeze(2)
        momentum = (u * gradient).sum(-1)
        force = (u * gradient_rate).sum(-1) + (w * gradient).sum(-1)
        return torch.cat([value.unsqueeze(-1), rate.unsqueeze(-1), momentum, force], dim=-1)

    def _pairs(self, mass: bool) -> list[tuple[int, int]]:
        of_mass = [(1 + c, 1 + d) for c, d in self.kinetic_features.mass_pairs] if mass else []
        return [(0, 1 + c) for c in range(self.n_q)] + of_mass


def _coefficients(n: int, generator: np.random.Generator) -> np.ndarray:
    limit = np.sqrt(6.0 / (n + 1))
    return generator.uniform(-limit, limit, n)
