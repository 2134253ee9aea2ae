"""The true Lagrangian as a model: the row that no learned model can beat."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import ClassVar, Literal, cast

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.mechanics.chain import Chain
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.context import Context
from repro.models.damped import Damped
from repro.models.expression import Weightless
from repro.models.features import FeatureMap
from repro.models.lagrangian import Lagrangian
from repro.models.model import EnergyExpressions, Model
from repro.models.model_options import ModelOptions
from repro.models.products import Features, Maths, Scalars

POINTS = 200  # where the true energies are looked at, many more than coefficients


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=truth; damping `diagonal`: with the true friction."""

    fitted: ClassVar[bool] = False
    from_true_system: ClassVar[bool] = True

    damping: Literal["none", "diagonal"] = "none"


class ChainTerms:
    """The terms that T and V of a cart with a chain of links are made of, as a basis."""

    LINEAR = True

    @staticmethod
    def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
        """xd^2, and for all links j >= k: xd thd_j cos th_j, thd_j thd_k cos(th_j - th_k)."""
        terms = {"xd^2": qd[0] ** 2}
        for j in range(1, len(q)):
            terms[f"xd thd{j} cos(th{j})"] = qd[0] * qd[j] * m.cos(q[j])
            terms[f"thd{j}^2"] = qd[j] ** 2
            for k in range(1, j):
                terms[f"thd{k} thd{j} cos(th{k} - th{j})"] = qd[k] * qd[j] * m.cos(q[k] - q[j])
        return terms

    @staticmethod
    def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
        """cos th_j."""
        return {f"cos(th{j})": m.cos(q[j]) for j in range(1, len(q))}


class Truth(Lagrangian):
    """A Lagrangian in the terms of a chain of links, its coefficients those of the true system; nothing is fitted."""

    def __init__(self, system: System) -> None:
        super().__init__(cast(ModuleType, ChainTerms), system.n_q)
        self.fixed = slice(0, self.n_parameters)
        self.coefficients = _coefficients(system, self.kinetic_features, self.potential_features)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """The true coefficients, the same for every member."""
        return np.repeat(self.coefficients[None], len(generators), axis=0)


class DampedTruth(Damped):
    """The true system with the friction of its joints as further coefficients."""

    def __init__(self, system: System) -> None:
        super().__init__(Truth(system), "diagonal")
        self.fixed = slice(0, self.n_parameters)
        self.friction_of_joints = np.array(system.damping)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """The true coefficients, the same for every member."""
        start = super().initial(generators)
        start[:, self.damping_slice] = self.friction_of_joints
        return start


class Exact(Weightless):
    """T and V of the true system, the coupling of its rates within T; its friction too where `damped`."""

    def __init__(self, system: System, damped: bool = False) -> None:
        super().__init__(system.n_q)
        self.system, self.damped = system, damped

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """The true T and V."""
        at, rates = casadi.vertsplit(q), casadi.vertsplit(qd)
        kinetic = self.system.kinetic(at, rates, casadi) + self.system.coupling(at, rates, casadi)
        return EnergyExpressions(casadi.SX(kinetic), casadi.SX(self.system.potential(at, casadi)))

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """The slopes of the Rayleigh function."""
        if not self.damped:
            return super().friction(q, qd, parameters)
        dissipation = self.system.dissipation(casadi.vertsplit(q), casadi.vertsplit(qd), casadi)
        return casadi.gradient(casadi.SX(dissipation), qd)


def true_model(system: System, damped: bool) -> Model:
    """The true system with weights where it is a chain of links, so that they can be made wrong; else without."""
    if isinstance(system, Chain) and not (damped and not _is_viscous(system)):
        try:
            return DampedTruth(system) if damped else Truth(system)
        except UserError:  # the printed double pendulum is no chain's
            pass
    return Exact(system, damped)


def _is_viscous(system: Chain) -> bool:
    """Whether its friction is a constant times the rate of each joint, relative to the link before."""
    relative = system.damping_frame == "relative" or system.n_q == 2  # of one link both frames are the same
    return not any(system.coulomb) and (not any(system.damping) or (relative and not system.damping_growth))


def _coefficients(system: System, kinetic: FeatureMap, potential: FeatureMap) -> np.ndarray:
    """The coefficients by which the terms make up the true energies; UserError where they do not."""
    generator = np.random.default_rng(0)
    q, qd = generator.uniform(-np.pi, np.pi, (2, POINTS, system.n_q))
    dynamics = dynamics_of(system)
    found = []
    for features, energy in ((kinetic, dynamics.kinetic), (potential, dynamics.potential)):
        symbols = [casadi.SX.sym(name, system.n_q) for name in ("q", "qd")]
        terms = casadi.Function("terms", symbols, [features.expression(*symbols)])
        columns, values = evaluate(terms, q, qd), evaluate(energy, q, qd)[:, 0]
        solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
        if not np.allclose(columns @ solution, values, rtol=0, atol=1e-9 * np.abs(values).max()):
            raise UserError(f"model=truth: the energies of {system.name}, are no chain's")
        found.append(solution)
    return np.concatenate(found)


def build(context: Context, options: Options) -> Model:
    """The model; UserError without the true system."""
    return true_model(context.true_system, options.damping != "none")
