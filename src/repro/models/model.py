"""What every model offers to the fitting, the evaluation and the control."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi
import numpy as np
import torch
from torch import Tensor

from repro.mechanics.derive import derive
from repro.models.terms import Terms

Prepared = dict[str, Tensor]


@dataclass(frozen=True)
class Energies:
    """CasADi expressions of a learned Lagrangian's parts, in J."""

    kinetic: casadi.SX
    potential: casadi.SX


class Model(ABC):
    """An ensemble of models: the weights of all members are the rows of one array (member, n_parameters).

    A prediction is made in two steps, so that per-sample gradients are cheap: `outputs` are what the weights act on
    (network outputs and their derivatives), `terms` is the physics made of them, without weights.
    """

    n_q: int
    inverse = True  # predicts tau: the inverse objective applies
    energetic = True  # has a Lagrangian

    @property
    @abstractmethod
    def n_parameters(self) -> int:
        """Number of weights of one member."""

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of the parameters of a model that is linear in them."""
        return ()

    @abstractmethod
    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Random starting weights, (member, n_parameters)."""

    @abstractmethod
    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """All that the model needs of the data, computed once; arrays (member, sample, ...) each, inputs (..., n_q)."""

    @abstractmethod
    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """What the weights act on; `mass` asks for all that the mass matrix needs."""

    @abstractmethod
    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """The physics made of the outputs."""

    @abstractmethod
    def pull(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients (member, row, sample, n_parameters) from cotangents (member, row, sample, ...) of the outputs."""

    @abstractmethod
    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> Energies:
        """The learned T and V as CasADi expressions of columns q, qd (n_q,) and one member's parameters."""

    def acceleration(self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """qdd as a CasADi expression: the forward dynamics of the learned Lagrangian."""
        energies = self.energies(q, qd, parameters)
        derived = derive(energies.kinetic, energies.potential, casadi.SX(0), q, qd, parameters)
        return derived.acceleration(q, qd, tau, parameters)

    def transformed_momentum(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """p_tran = M_hat(q) qd, eq. (8), as a CasADi expression; only for models with a momentum transform."""
        raise NotImplementedError(f"{type(self).__name__} has no momentum transform")

    def evaluate(self, parameters: Tensor, prepared: Prepared, mass: bool = False) -> Terms:
        """Predictions on prepared data."""
        return self.terms(self.outputs(parameters, prepared, mass), prepared)

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
            return values.detach(), self.pull(parameters, prepared, cotangents)
