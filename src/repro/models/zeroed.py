"""A model whose angles are read from encoders that are off by a constant each: theta - b in the place of theta."""

from collections.abc import Sequence

import casadi
import numpy as np

from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions, Model


class Zeroed(ExpressionModel):
    """The energies and the friction of another model at q - b; parameters: [those of the model | b, rad].

    An angle that changes neither T nor V has no zero: its b is not determined by any motion.
    """

    def __init__(self, model: Model, angles: Sequence[int]) -> None:
        self.model, self.n_q, self.angles = model, model.n_q, tuple(angles)
        self.n_parameters = model.n_parameters + len(self.angles)
        self.fixed, self.linear_in_weights = model.fixed, model.linear_in_weights

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of the model's coefficients, then b1, b2, ... by coordinate."""
        return (*self.model.coefficient_names, *(f"b{angle}" for angle in self.angles))

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """The model's start, with encoders at zero."""
        return np.pad(self.model.initial(generators), ((0, 0), (0, len(self.angles))))

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """The model's T and V at the true angles."""
        return self.model.energies(self._true(q, parameters), qd, self._own(parameters))

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """The model's friction at the true angles."""
        return self.model.friction(self._true(q, parameters), qd, self._own(parameters))

    def _own(self, parameters: casadi.SX) -> casadi.SX:
        return parameters[: self.model.n_parameters]

    def _true(self, q: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        shifted = casadi.SX(q)
        for number, angle in enumerate(self.angles, start=self.model.n_parameters):
            shifted[angle] -= parameters[number]
        return shifted
