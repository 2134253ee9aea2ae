"""The trivial anchor row: tau = 0, qdd = 0, no energy."""

from collections.abc import Sequence

import casadi
import numpy as np
import torch
from torch import Tensor

from repro.models.model import EnergyExpressions, Model, Prepared
from repro.models.terms import Terms


class Trivial(Model):
    """What predicting nothing scores; a result that does not beat it is none."""

    n_parameters = 0

    def __init__(self, n_q: int) -> None:
        self.n_q = n_q

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No weights."""
        return np.zeros((len(generators), 0))

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """Zeros in the shape of the data."""
        return {"zeros": np.zeros_like(q)}

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """Nothing depends on weights."""
        return []

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """Zero, wherever a number is asked for."""
        zeros = prepared["zeros"]
        scalar = zeros[..., 0]
        return Terms(tau=zeros, momentum=zeros, kinetic=scalar, potential=scalar, acceleration=zeros)

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """No weights, no gradients."""
        return torch.zeros(0)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """No energy."""
        return EnergyExpressions(casadi.SX(0), casadi.SX(0))
