"""T = qd' M(q) qd / 2 with M(q) = C(q) C(q)' positive semi-definite by construction, V in cosines or a network."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.models.context import Context
from repro.models.damped import with_damping
from repro.models.features import FeatureMap
from repro.models.model import EnergyExpressions, Model, Prepared, consecutive
from repro.models.model_options import Activation, Damping, Factor, Initialisation, ModelOptions
from repro.models.network import Network
from repro.models.position import PositionFeatures, cart_with_links
from repro.models.terms import Terms
from repro.plugins.options import Count, NotNegative


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=structured: what each is stands in conf/model/structured.yaml."""

    runs_on_device: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (8,)
    factor: Factor = "wide"
    rank: Count | None = None
    activation: Activation = "tanh"
    skip: bool = True
    scaled: bool = True
    initialisation: Initialisation = "inertia"
    potential: Literal["auto", "cosines", "network", "shared"] = "auto"
    potential_hidden: tuple[Count, ...] = (16,)
    damping: Damping = "none"
    floor: NotNegative = 0.0

    def problems(self) -> Iterator[str]:
        """A triangular factor has no rank to choose."""
        if self.rank is not None and self.factor == "triangular":
            yield (
                f"model.rank = {self.rank}: a triangular factor has as many columns as coordinates; use "
                "model.factor=wide"
            )

    def device_problem(self) -> str | None:
        """A triangular factor is not computed by torch."""
        return "model.factor=triangular" if self.factor == "triangular" else None


class Structured(Model):
    """A wide factor C (n_q, rank), rank > n_q, from a network of {cos, sin} with a linear path; T(q, 0) = 0 is exact.

    With a square factor the rank-deficient matrices are walls that a fit cannot cross; with rank >= n_q + 2 the path
    goes round them. Velocities are divided by `velocity_scale` (n_q,), so that the start M = diag(scale^-2) has the
    inertia scale of the data. A network for V has the inputs of that for C. parameters: [weights of C | beta, or of V].
    """

    def __init__(
        self,
        n_q: int,
        velocity_scale: np.ndarray,
        options: Options,
        positions: PositionFeatures | None = None,
    ) -> None:
        positions = positions or cart_with_links(n_q)
        triangular, activation = options.factor == "triangular", options.activation
        self.n_q, self.initialisation, self.floor = n_q, options.initialisation, options.floor
        self.rank = n_q if triangular else options.rank or n_q + 2
        shape = (n_q, self.rank)
        self._entries = np.flatnonzero(np.tril(np.ones(shape)) if triangular else np.ones(shape))
        self.velocity_scale = np.asarray(velocity_scale, dtype=float) if options.scaled else np.ones(n_q)
        self.features = FeatureMap(positions.inertia, n_q)
        self.potential_features = FeatureMap(positions.potential, n_q)
        self.potential_shared = options.potential == "shared"
        n_out = len(self._entries) + int(self.potential_shared)
        self.network = Network(len(self.features), options.hidden, n_out, activation, options.skip)
        self.potential: Network | None = None
        if options.potential == "network" or (options.potential == "auto" and not positions.upright_angles):
            self.potential = Network(len(self.features), options.potential_hidden, 1, activation, True)
        n_potential = len(self.potential_features) if self.potential is None else self.potential.n_parameters
        n_potential = 0 if self.potential_shared else n_potential
        self.network_slice, self.potential_slice = consecutive(self.network.n_parameters, n_potential)
        self.n_parameters = self.potential_slice.stop
        self._slopes = [0, *range(2, 2 + n_q)]

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Small random output weights around C = [I 0], so that M starts as diag(velocity_scale^-2).

        A linear V starts at 0, a network at random.
        """
        if self.initialisation == "glorot":
            networks = self.network.initial(generators)
        else:
            networks = np.stack([self._network_start(generator) for generator in generators])
        if self.potential is None:
            return np.pad(networks, ((0, 0), (0, self.n_parameters - networks.shape[1])))
        return np.concatenate([networks, self.potential.initial(generators)], axis=1)

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """Position jets [z, zdot, dz/dq_c] (..., 2 + n_q, n_z), rows [z, dz/dq_c] of V, scaled velocities."""
        n_q, jets, prepared = self.n_q, self.features.jets(q, qd, qdd), {}
        if self.potential is None and not self.potential_shared:
            rows = self.potential_features.potential_rows(q, qd, qdd)
            prepared["potential"] = np.concatenate([rows[..., :1, :], -rows[..., 1:, :]], axis=-2)
        return prepared | {
            "position": np.concatenate([jets[..., :2, :], -jets[..., 2 + n_q : 2 + 2 * n_q, :]], axis=-2),
            "velocity": qd / self.velocity_scale,
            "acceleration": qdd / self.velocity_scale,
            "scale": np.broadcast_to(self.velocity_scale, qd.shape).copy(),
        }

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """C and its derivatives along the motion and each coordinate (..., 2 + n_q, n_entries), and [V, dV/dq_c]."""
        factor = self.network.propagate(parameters[:, self.network_slice], prepared["position"])
        weights = parameters[:, self.potential_slice]
        if self.potential_shared:
            return [factor[..., :-1], factor[:, :, self._slopes, -1]]
        if self.potential is None:
            return [factor, torch.einsum("mnji,mi->mnj", prepared["potential"], weights)]
        return [factor, self.potential.propagate(weights, prepared["position"][:, :, self._slopes])[..., 0]]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """tau = M qdd + Mdot qd - d/dq (qd' M qd) / 2 + dV/dq."""
        factor = self._floored(self._factor(outputs[0]))
        potential = outputs[1]
        c, rate, slopes = factor[:, :, 0], factor[:, :, 1], factor[:, :, 2:]
        velocity, acceleration, scale = prepared["velocity"], prepared["acceleration"], prepared["scale"]
        u = torch.einsum("mnir,mni->mnr", c, velocity)
        u_rate = torch.einsum("mnir,mni->mnr", rate, velocity)
        u_push = torch.einsum("mnir,mni->mnr", c, acceleration)
        momentum = torch.einsum("mnir,mnr->mni", c, u) / scale
        inertial = torch.einsum("mnir,mnr->mni", c, u_push + u_rate) + torch.einsum("mnir,mnr->mni", rate, u)
        slope_power = torch.einsum("mnkir,mni,mnr->mnk", slopes, velocity, u)
        return Terms(
            tau=inertial / scale - slope_power + potential[..., 1:],
            momentum=momentum,
            kinetic=0.5 * (u * u).sum(-1),
            potential=potential[..., 0],
            mass=torch.einsum("mnir,mnjr->mnij", c, c) / (scale.unsqueeze(-1) * scale.unsqueeze(-2)),
        )

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        weights = parameters[:, self.network_slice]
        if self.potential_shared:
            whole = torch.nn.functional.pad(cotangents[0], (0, 1))
            whole[:, :, :, self._slopes, -1] = cotangents[1]
            return self.network.jacobian(weights, prepared["position"], whole)
        network = self.network.jacobian(weights, prepared["position"], cotangents[0])
        if self.potential is None:
            potential = torch.einsum("mrnj,mnji->mrni", cotangents[1], prepared["potential"])
        else:
            rows, own = prepared["position"][:, :, self._slopes], parameters[:, self.potential_slice]
            potential = self.potential.jacobian(own, rows, cotangents[1].unsqueeze(-1))
        return torch.cat([network, potential], dim=-1)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T and V as CasADi expressions."""
        output = self.network.expression(parameters[self.network_slice], self.features.expression(q, qd))
        entries = casadi.SX(self.n_q * self.rank, 1)
        entries[self._entries.tolist()] = output[: len(self._entries)]
        factor = casadi.reshape(entries, self.rank, self.n_q)
        u = factor @ (qd / casadi.DM(self.velocity_scale))
        if self.floor:
            u = casadi.vertcat(u, self.floor**0.5 * qd / casadi.DM(self.velocity_scale))
        weights = parameters[self.potential_slice]
        if self.potential_shared:
            potential = output[-1]
        elif self.potential is None:
            potential = casadi.dot(weights, self.potential_features.expression(q, qd))
        else:
            potential = self.potential.expression(weights, self.features.expression(q, qd))
        return EnergyExpressions(0.5 * casadi.dot(u, u), potential)

    def _factor(self, entries: Tensor) -> Tensor:
        """Return C and its derivatives (..., n_q, rank) from the network's outputs (..., n_entries)."""
        size = self.n_q * self.rank
        if len(self._entries) < size:
            whole = entries.new_zeros((*entries.shape[:-1], size))
            entries = whole.index_copy(-1, torch.from_numpy(self._entries), entries)
        return entries.reshape(*entries.shape[:-1], self.n_q, self.rank)

    def _floored(self, factor: Tensor) -> Tensor:
        """[C, sqrt(floor) I] and its derivatives, so that M = C C' + floor in the scale of the velocities."""
        if not self.floor:
            return factor
        constant = factor.new_zeros((*factor.shape[:-1], self.n_q))
        constant[:, :, 0] = self.floor**0.5 * torch.eye(self.n_q, dtype=factor.dtype)
        return torch.cat([factor, constant], dim=-1)

    def _network_start(self, generator: np.random.Generator) -> np.ndarray:
        n_hidden_layers = len(self.network.hidden)
        arrays = []
        for index, shape in enumerate(self.network.shapes):
            output_layer = index // 2 == n_hidden_layers
            if len(shape) == 2:
                draw = generator.normal(0, 1 / np.sqrt(shape[1]), shape)
                arrays.append(0.1 * draw if output_layer or index == 2 * n_hidden_layers + 2 else draw)
            elif output_layer:
                start = np.eye(self.n_q, self.rank).ravel()[self._entries]
                arrays.append(np.append(start, 0.0) if self.potential_shared else start)
            else:
                arrays.append(generator.normal(0, 0.5, shape))
        return np.concatenate([array.ravel() for array in arrays])


def build(context: Context, options: Options) -> Model:
    """The model, beside friction where chosen."""
    model = Structured(context.n_q, context.velocity_scale, options, context.positions)
    return with_damping(model, options.damping, context.positions)
