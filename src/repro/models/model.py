"""What every model offers to the fitting, the evaluation and the control."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.lazy_torch import Tensor, torch
from repro.mechanics.derive import euler_lagrange, solve_symmetric
from repro.models.terms import Terms

if TYPE_CHECKING:
    from repro.models.lagrangian import MomentumTransform

Prepared = dict[str, Tensor]
SAMPLES = ("q", "qd", "qdd", "tau")


def consecutive(*sizes: int) -> list[slice]:
    """Where parts of these sizes lie that follow each other."""
    return [slice(*ends) for ends in pairwise(accumulate(sizes, initial=0))]


def tensors(arrays: Mapping[str, np.ndarray]) -> Prepared:
    """The arrays as float64 tensors on the same memory; what may not be written, as a broadcast force, is copied."""
    return {name: torch.from_numpy(np.require(array, requirements="W")) for name, array in arrays.items()}


@dataclass(frozen=True)
class EnergyExpressions:
    """CasADi expressions of a learned Lagrangian's parts, in J."""

    kinetic: casadi.SX
    potential: casadi.SX


@dataclass(frozen=True)
class PortForm:
    """CasADi columns (2 n_q,) of eq. (5) at a state x = [q; p]: dH/dx, and (J - R) dH/dx, its motion without input."""

    gradient: casadi.SX
    drift: casadi.SX


class Model(ABC):
    """An ensemble of models: the weights of all members are the rows of one array (member, n_parameters).

    A prediction is made in two steps, so that per-sample gradients are cheap: `outputs` are what the weights act on
    (network outputs and their derivatives), `terms` is the physics made of them, without weights.
    """

    n_q: int
    n_parameters: int  # weights of one member
    inverse = True  # predicts tau: the inverse objective applies
    energetic = True  # has a Lagrangian
    transform: "MomentumTransform | None" = None  # of a momentum of its own, eq. (8)
    transform_slice = slice(0, 0)  # the weights of that
    not_symbolic: str | None = None  # why it has no CasADi expressions, where it has none
    linear_in_weights = False  # tau is linear in the weights
    fixed = slice(0, 0)  # weights that a fit does not change
    upstream = slice(0, 0)  # weights that come from trained sub-models, the same for every random start

    @property
    def transforms(self) -> bool:
        """Whether it has a momentum of its own, eq. (8)."""
        return self.transform is not None

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of the parameters of a model that is linear in them."""
        return ()

    def symbols(self, *names: str) -> list[casadi.SX]:
        """Columns (n_q,) of these names, and the weights of one member (n_parameters,)."""
        columns = [casadi.SX.sym(name, self.n_q) for name in names]
        return [*columns, casadi.SX.sym("parameters", self.n_parameters)]

    @abstractmethod
    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Random starting weights, (member, n_parameters)."""

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """All that the model needs of the data, computed once; arrays (member, sample, ...) each, inputs (..., n_q).

        The samples themselves, by the names `SAMPLES`, unless said.
        """
        # torch takes writable arrays alone
        return {name: np.require(a, requirements="W") for name, a in zip(SAMPLES, (q, qd, qdd, tau), strict=True)}

    @abstractmethod
    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """What the weights act on; `mass`: with all that the mass matrix needs."""

    @abstractmethod
    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """The physics made of the outputs."""

    @abstractmethod
    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients (member, row, sample, n_parameters) from cotangents (member, row, sample, ...) of the outputs."""

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """The learned T and V as CasADi expressions of columns q, qd (n_q,) and one member's parameters.

        NotImplementedError for a model without a Lagrangian, or without expressions.
        """
        raise NotImplementedError(f"{type(self).__name__} has no T and V as expressions")

    def part_energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> list[EnergyExpressions]:
        """T and V of each sub-system of an interconnection, at q and qd of the whole; [] unless said."""
        return []

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """The forces (n_q,) against the motion that L does not know, as a CasADi expression; 0 unless said."""
        return casadi.SX.zeros(self.n_q)

    def inverse_dynamics(self, q: casadi.SX, qd: casadi.SX, qdd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """tau = d/dt(dL/dqd) - dL/dq + friction, eq. (2), as a CasADi expression."""
        energies = self.energies(q, qd, parameters)
        lagrangian = energies.kinetic - energies.potential
        return euler_lagrange(lagrangian, q, qd, qdd) + self.friction(q, qd, parameters)

    def acceleration(self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """qdd as a CasADi expression: the forward dynamics; not finite where the mass matrix is singular."""
        rest = self.inverse_dynamics(q, qd, casadi.SX.zeros(self.n_q), parameters)
        return solve_symmetric(self.mass_matrix(q, qd, parameters), tau - rest)

    def momentum(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """p = dL/dqd as a CasADi expression."""
        energies = self.energies(q, qd, parameters)
        return casadi.gradient(energies.kinetic - energies.potential, qd)

    def mass_matrix(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """M = dp/dqd (n_q, n_q) as a CasADi expression."""
        return casadi.jacobian(self.momentum(q, qd, parameters), qd)

    def port_form(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> PortForm:
        """Eq. (5) with the canonical J, at p = dL/dqd: dH/dq = -dL/dq and dH/dp = qd, whatever L is."""
        energies = self.energies(q, qd, parameters)
        push = casadi.gradient(energies.kinetic - energies.potential, q)
        return PortForm(casadi.vertcat(-push, qd), casadi.vertcat(qd, push - self.friction(q, qd, parameters)))

    def port_values(self, weights: np.ndarray, q: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Both of `port_form` as numbers, (..., 2 n_q) each, at q, qd (..., n_q) and one member's weights."""
        gradient, drift = np.split(evaluate(_port_function(self), q, qd, weights), 2, axis=-1)
        return gradient, drift

    def port_error(
        self, q: casadi.SX, qd: casadi.SX, qdd: casadi.SX, tau: casadi.SX, parameters: casadi.SX
    ) -> casadi.SX:
        """Eq. (12b): drift plus input, minus the measured rates of q and of p = dL/dqd, (2 n_q,)."""
        momentum = self.momentum(q, qd, parameters)
        rate = casadi.jtimes(momentum, q, qd) + casadi.jtimes(momentum, qd, qdd)
        drift = self.port_form(q, qd, parameters).drift
        return drift + casadi.vertcat(casadi.SX.zeros(self.n_q), tau) - casadi.vertcat(qd, rate)

    def implicit_error(
        self, q: casadi.SX, qd: casadi.SX, qdd: casadi.SX, tau: casadi.SX, parameters: casadi.SX
    ) -> casadi.SX:
        """The error (n_q,) of the model's own equation, linear in its weights; only of models with `implicit_form`."""
        raise NotImplementedError(f"{type(self).__name__} has no implicit equation")

    def transformed_momentum(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """p_tran = M_hat(q) qd, eq. (8), as a CasADi expression; only for models with a momentum transform."""
        if self.transform is None:
            raise NotImplementedError(f"{type(self).__name__} has no momentum transform")
        return self.transform.expression(q, qd, parameters[self.transform_slice])

    def evaluate(self, parameters: Tensor, prepared: Prepared, mass: bool = False) -> Terms:
        """Predictions on prepared data."""
        return self.terms(self.outputs(parameters, prepared, mass), prepared)

    def acceleration_at(self, parameters: Tensor, q: Tensor, qd: Tensor, tau: Tensor) -> Tensor:
        """qdd (member, sample, n_q), differentiable in all arguments, of a model that is `differentiable`."""
        raise NotImplementedError(f"{type(self).__name__} has no differentiable motion")

    def state(self, motion: np.ndarray) -> np.ndarray:
        """What the model integrates, from motion [q, qd] (..., 2 n_q): the same unless said."""
        return motion

    def motion_of(self, parameters: Tensor, state: np.ndarray) -> np.ndarray:
        """[q, qd] (member, sample, 2 n_q) from what the model integrates."""
        return state

    def state_rate(self, parameters: Tensor, state: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """The rate of what it integrates, (member, sample, 2 n_q), under tau (member, sample, n_q)."""
        q, qd = np.split(state, 2, axis=-1)
        return np.concatenate([qd, self.accelerations(parameters, q, qd, tau)], axis=-1)

    def accelerations(self, parameters: Tensor, q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """qdd (member, sample, n_q) by torch, of any model; arguments (member, sample, n_q)."""
        zero = np.zeros_like(q)
        samples = [np.require(array, requirements=("C", "W")) for array in (q, qd, zero, tau)]
        with torch.no_grad():
            terms = self.evaluate(parameters, tensors(self.prepare(*samples)), mass=True)
            error = terms.acceleration_error(torch.from_numpy(zero), torch.from_numpy(samples[-1]))
        found: np.ndarray = error.numpy()
        return found

    def rows(
        self, parameters: Tensor, prepared: Prepared, residual: Callable[[Terms], Tensor], mass: bool
    ) -> tuple[Tensor, Tensor]:
        """Rows (member, sample, row) of `residual(terms)` and their gradients (member, row, sample, n_parameters)."""
        with torch.no_grad():
            outputs = self.outputs(parameters, prepared, mass)
        leaves = [output.detach().requires_grad_() for output in outputs]
        values = residual(self.terms(leaves, prepared))
        per_row = [
            torch.autograd.grad(values[..., r].sum(), leaves, retain_graph=True, materialize_grads=True)
            for r in range(values.shape[-1])
        ]
        cotangents = [torch.stack(parts, dim=1) for parts in zip(*per_row, strict=True)]
        with torch.no_grad():
            return values.detach(), self.vjp(parameters, prepared, cotangents)


@lru_cache(maxsize=16)
def _port_function(model: Model) -> casadi.Function:
    symbols = model.symbols("q", "qd")
    form = model.port_form(*symbols)
    return column_function("port", symbols, form.gradient, form.drift)


@lru_cache(maxsize=16)
def acceleration(model: Model) -> casadi.Function:
    """qdd = f(q, qd, tau, parameters) of a model, as a CasADi function."""
    symbols = model.symbols("q", "qd", "tau")
    return column_function("acceleration", symbols, model.acceleration(*symbols))
