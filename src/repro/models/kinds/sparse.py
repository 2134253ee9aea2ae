"""A sparse equation of motion: qdd as a sum of library terms, or as a ratio of two such sums."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.lazy_torch import Tensor, torch
from repro.models.context import Context
from repro.models.model import Model, Prepared
from repro.models.model_options import ModelOptions
from repro.models.position import PositionFeatures
from repro.models.terms import Terms
from repro.plugins.options import Count

TERM = "q{0}dd"


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=sparse: what each is stands in conf/model/sparse.yaml."""

    energetic: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    implicit_form: ClassVar[bool] = True

    form: Literal["explicit", "implicit"] = "implicit"
    order: Count = 2

    def is_linear(self, basis_is_linear: bool) -> bool:
        """Its own equation is, on any basis."""
        return True


class Sparse(Model):
    """qdd_i = theta . xi_i (SINDy, Brunton et al. 2016), or qdd_i (1 + g . eta_i) = theta . xi_i (SINDy-PI's form).

    h: products of at most `order` cosines, sines and translations, without sin^2, which is 1 - cos^2. theta: h times
    1, products of two rates, one rate (friction) and each component of the force; g: h without 1. The equation times
    its denominator is linear in all weights, which is what is fitted (objective=implicit; Kaheman et al. 2020 with a
    fixed left side). parameters: [xi_1, eta_1, xi_2, ...].
    """

    inverse = False
    energetic = False
    linear_in_weights = True

    def __init__(self, n_q: int, positions: PositionFeatures, options: Options) -> None:
        self.n_q, self.positions = n_q, positions
        self.order, self.implicit = options.order, options.form == "implicit"
        q, qd, tau = (casadi.SX.sym(name, n_q) for name in ("q", "qd", "tau"))
        library, denominator = self._terms(*(casadi.vertsplit(each) for each in (q, qd, tau)))
        self.library_names, self.denominator_names = tuple(library), tuple(denominator)
        self._sizes = [len(library), len(denominator)]
        self.n_parameters = n_q * sum(self._sizes)
        self._library = column_function("library", [q, qd, tau], *library.values(), *denominator.values())

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of all terms, equation by equation."""
        names = [*self.library_names, *(f"{TERM} {name}" for name in self.denominator_names)]
        return tuple(f"{TERM}: {name}".format(i) for i in range(self.n_q) for name in names)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Zeros: a closed form has no start."""
        return np.zeros((len(generators), self.n_parameters))

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """The library [theta, g] (..., n_terms), and qdd."""
        return {"library": evaluate(self._library, q, qd, tau), "qdd": qdd}

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """Numerators and denominators less 1, (member, sample, n_q) each."""
        theta, g = torch.split(prepared["library"], self._sizes, dim=-1)
        xi, eta = torch.split(parameters.unflatten(1, (self.n_q, -1)), self._sizes, dim=-1)
        return [torch.einsum("mnt,mit->mni", theta, xi), torch.einsum("mnt,mit->mni", g, eta)]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """The acceleration, and the residual of the equation times its denominator."""
        numerator, denominator = outputs[0], 1 + outputs[1]
        return Terms(acceleration=numerator / denominator, implicit_error=numerator - denominator * prepared["qdd"])

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        columns = torch.split(prepared["library"], self._sizes, dim=-1)
        parts = [torch.einsum("mrni,mnt->mrnit", c, each) for c, each in zip(cotangents, columns, strict=True)]
        return torch.cat(parts, dim=-1).flatten(-2)

    def acceleration(self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """qdd as a CasADi expression."""
        numerator, denominator = self._sums(q, qd, tau, parameters)
        return numerator / denominator

    def implicit_error(
        self, q: casadi.SX, qd: casadi.SX, qdd: casadi.SX, tau: casadi.SX, parameters: casadi.SX
    ) -> casadi.SX:
        """Numerators minus denominators times qdd."""
        numerator, denominator = self._sums(q, qd, tau, parameters)
        return numerator - denominator * qdd

    def _sums(self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX) -> tuple[casadi.SX, casadi.SX]:
        columns, n_theta = self._library(q, qd, tau), len(self.library_names)
        weights = casadi.reshape(parameters, -1, self.n_q)
        return weights[:n_theta, :].T @ columns[:n_theta], 1 + weights[n_theta:, :].T @ columns[n_theta:]

    def _terms(self, q: Sequence[Any], qd: Sequence[Any], tau: Sequence[Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        factors = self.positions.inertia(q, qd, casadi)
        shapes: dict[str, Any] = {"1": 1.0}
        for count in range(1, self.order + 1):
            for names in itertools.combinations_with_replacement(factors, count):
                if all(names.count(name) < 2 or not name.startswith("sin") for name in names):
                    shapes[" ".join(names)] = math.prod(factors[name] for name in names)
        rates: dict[str, Any] = {"": 1.0}
        indices = range(self.n_q)
        rates |= {f"q{i}d": qd[i] for i in indices}
        rates |= {f"q{i}d q{j}d": qd[i] * qd[j] for i, j in itertools.combinations_with_replacement(indices, 2)}
        rates |= {f"tau{i}": tau[i] for i in indices}
        library = {
            f"{rate} {shape}".strip(): value * factor
            for rate, value in rates.items()
            for shape, factor in shapes.items()
            if shape == "1" or rate.count("d") != 1
        }
        denominator = {name: value for name, value in shapes.items() if name != "1"} if self.implicit else {}
        return library, denominator


def build(context: Context, options: Options) -> Model:
    """The model."""
    return Sparse(context.n_q, context.positions, options)
