"""A Hamiltonian neural network: H(q, p) as one network, on momenta that are given."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, Literal

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.lazy_torch import Tensor, torch
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.context import Context, spread_of
from repro.models.features import FeatureMap
from repro.models.model import Model, Prepared, consecutive
from repro.models.model_options import Activation, ModelOptions
from repro.models.network import Network
from repro.models.position import PositionFeatures
from repro.models.products import Features, Maths, Scalars
from repro.models.terms import Terms, symmetric
from repro.plugins.options import Count


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=hamiltonian; dissipation `constant`: a diagonal D is learned too (Desai et al. 2021)."""

    energetic: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    from_true_system: ClassVar[bool] = True
    port_form: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (200, 200)
    activation: Activation = "tanh"
    dissipation: Literal["none", "constant"] = "none"


class Hamiltonian(Model):
    """qdot = dH/dp, pdot = -dH/dq - D dH/dp + tau (Greydanus et al. 2019; D as in Desai et al. 2021).

    The network sees what others see of positions, and p divided by `momentum_scale` (n_q,). p and its rate come from
    the true system at the recorded q, qd, qdd. With `constant` dissipation D is diagonal, of squared weights d.
    parameters: [weights of H | d]. Its motion is integrated in (q, p), and its velocities are its own dH/dp.
    """

    inverse = False
    energetic = False
    not_symbolic = "it is a function of momenta that the true system gives"

    def __init__(
        self, system: System, positions: PositionFeatures, momentum_scale: np.ndarray, options: Options
    ) -> None:
        self.n_q, self.system = system.n_q, system
        scale = momentum_scale.tolist()

        def features(q: Scalars, p: Scalars, m: Maths) -> Features:
            return positions.inertia(q, p, m) | {f"p{i}": p[i] / scale[i] for i in range(system.n_q)}

        self.features = FeatureMap(features, self.n_q)
        self.network = Network(len(self.features), options.hidden, 1, options.activation)
        n_damping = self.n_q if options.dissipation == "constant" else 0
        self.network_slice, self.damping_slice = consecutive(self.network.n_parameters, n_damping)
        self.n_parameters = self.damping_slice.stop
        n = self.n_q
        upper = [(n + i, n + j) for i in range(n) for j in range(i, n)]
        self._pairs = [(n + i, j) for i in range(n) for j in range(n)] + upper

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights, zero biases, a small friction."""
        network = self.network.initial(generators)
        return np.pad(network, ((0, 0), (0, self.n_parameters - network.shape[1])), constant_values=0.1)

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """Jets [z, dz/dq, dz/dp, 0 ..] (..., 1 + 2 n_q + n_pairs, n_z), and the rates that they are compared with."""
        momentum, rate = np.split(evaluate(_momentum(self.system), q, qd, qdd), 2, axis=-1)
        return {"jets": self._jets(q, momentum), "qd": qd, "tau": tau, "rate": rate}

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """[H, dH/dq, dH/dp, with `mass` d2H/dp dq and d2H/dp2] (..., n_rows), and d (..., n_q) where there is one."""
        jets, weights = prepared["jets"], parameters[:, self.network_slice]
        if mass:
            stack = self.network.propagate(weights, jets, self._pairs)[..., 0]
        else:
            value, gradient = self.network.gradient(weights, jets[:, :, 0])
            slopes = jets[:, :, 1 : 1 + 2 * self.n_q] @ gradient.unsqueeze(-1)
            stack = torch.cat([value.unsqueeze(-1), slopes.squeeze(-1)], dim=-1)
        friction = parameters[:, self.damping_slice]
        return [stack, friction.unsqueeze(1).expand(-1, stack.shape[1], -1)] if friction.shape[1] else [stack]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """H, the error of both rates, and with the second derivatives qdd = d/dt dH/dp."""
        n, stack = self.n_q, outputs[0]
        energy, by_q, by_p = torch.split(stack[..., : 1 + 2 * n], [1, n, n], dim=-1)
        push = prepared["tau"] - by_q
        if len(outputs) > 1:
            push = push - outputs[1] ** 2 * by_p
        acceleration = None
        if stack.shape[-1] > 1 + 2 * n:
            mixed, bend = torch.split(stack[..., 1 + 2 * n :], [n * n, n * (n + 1) // 2], dim=-1)
            along = mixed.unflatten(-1, (n, n)) @ by_p.unsqueeze(-1)
            acceleration = (along + symmetric(bend, n) @ push.unsqueeze(-1)).squeeze(-1)
        error = torch.cat([by_p - prepared["qd"], push - prepared["rate"]], dim=-1)
        return Terms(acceleration=acceleration, port_error=error, energy=energy[..., 0])

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        rows = cotangents[0].shape[-1]
        pairs = self._pairs if rows > 1 + 2 * self.n_q else []
        jets, weights = prepared["jets"][:, :, :rows], parameters[:, self.network_slice]
        network = self.network.jacobian(weights, jets, cotangents[0].unsqueeze(-1), pairs)
        return torch.cat([network, *cotangents[1:]], dim=-1)

    def state(self, motion: np.ndarray) -> np.ndarray:
        """[q, p] with the true momentum of [q, qd] (..., 2 n_q)."""
        q, qd = np.split(motion, 2, axis=-1)
        return np.concatenate([q, evaluate(_momentum(self.system), q, qd, np.zeros_like(q))[..., : self.n_q]], axis=-1)

    def motion_of(self, parameters: Tensor, state: np.ndarray) -> np.ndarray:
        """[q, dH/dp] of [q, p] (member, sample, 2 n_q)."""
        rates = self.state_rate(parameters, state, np.zeros_like(state[..., : self.n_q]))
        return np.concatenate([state[..., : self.n_q], rates[..., : self.n_q]], axis=-1)

    def state_rate(self, parameters: Tensor, state: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """[dH/dp, -dH/dq - D dH/dp + tau] (member, sample, 2 n_q)."""
        zero = torch.zeros(tau.shape, dtype=torch.float64)
        jets = torch.from_numpy(self._jets(*np.split(state, 2, axis=-1)))
        prepared = {"jets": jets, "qd": zero, "tau": torch.from_numpy(tau), "rate": zero}
        with torch.no_grad():
            rates: np.ndarray = self.evaluate(parameters, prepared).port_error.numpy()
        return rates

    def _jets(self, q: np.ndarray, p: np.ndarray) -> np.ndarray:
        n = self.n_q
        jets = self.features.jets(q, p, np.zeros_like(q))
        second = np.zeros((*q.shape[:-1], len(self._pairs), len(self.features)))  # q and p enter different features
        parts = [jets[..., :1, :], -jets[..., 2 + n : 2 + 2 * n, :], jets[..., 2 : 2 + n, :], second]
        return np.concatenate(parts, axis=-2)


@lru_cache(maxsize=16)
def _momentum(system: System) -> casadi.Function:
    """(q, qd, qdd) -> [p; dp/dt] of the true system."""
    q, qd, qdd = (casadi.SX.sym(name, system.n_q) for name in ("q", "qd", "qdd"))
    momentum = dynamics_of(system).momentum(q, qd, casadi.SX(0, 1))
    rate = casadi.jtimes(momentum, q, qd) + casadi.jtimes(momentum, qd, qdd)
    return column_function("momentum", [q, qd, qdd], momentum, rate)


def momentum_spread(system: System, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Standard deviation of the true momenta at samples (..., n_q), 1 where they do not change."""
    return spread_of(evaluate(_momentum(system), q, qd, np.zeros_like(q))[..., : system.n_q])


def build(context: Context, options: Options) -> Model:
    """The model; UserError without the true system."""
    system = context.true_system
    return Hamiltonian(system, context.positions, momentum_spread(system, context.q, context.qd), options)
