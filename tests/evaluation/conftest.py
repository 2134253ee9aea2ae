"""Models written as expressions, so that a gauge can be chosen, and exact data."""

from collections.abc import Callable

import casadi
import numpy as np
import pytest
import torch
from simulated import random_force

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import derive
from repro.mechanics.system import load
from repro.models.bases import t1
from repro.models.lagrangian import Lagrangian
from repro.models.model import EnergyExpressions, Model
from repro.models.terms import Terms

TRUE_T1 = [0.4, 0.025, 0.1, 0.98]


class Written(Model):
    """T and V as given functions of CasADi columns q, qd; no weights."""

    n_q, n_parameters = 2, 0

    def __init__(self, kinetic: Callable, potential: Callable) -> None:
        q, qd = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2)
        self.kinetic, self.potential = kinetic, potential
        self.dynamics = derive(casadi.SX(kinetic(q, qd)), casadi.SX(potential(q)), casadi.SX(0), q, qd)

    def initial(self, generators):
        return np.zeros((len(generators), 0))

    def prepare(self, q, qd, qdd, tau):
        d = self.dynamics
        rows = {name: evaluate(getattr(d, name), q, qd) for name in ("momentum", "mass_matrix", "kinetic", "potential")}
        return rows | {"tau": evaluate(d.inverse, q, qd, qdd)}

    def outputs(self, parameters, prepared, mass):
        return []

    def terms(self, outputs, prepared):
        p = prepared
        return Terms(
            tau=p["tau"], momentum=p["momentum"], mass=p["mass_matrix"],
            kinetic=p["kinetic"][..., 0], potential=p["potential"][..., 0],
        )  # fmt: skip

    def vjp(self, parameters, prepared, cotangents):
        return torch.zeros(0)

    def energies(self, q, qd, parameters):
        return EnergyExpressions(casadi.SX(self.kinetic(q, qd)), casadi.SX(self.potential(q)))


def _kinetic(q, qd):
    """A pendulum with masses that are a little wrong, so that every error is one."""
    return 0.43 * qd[0] ** 2 + 0.021 * qd[1] ** 2 + 0.11 * qd[0] * qd[1] * casadi.cos(q[1])


def _potential(q):
    return 0.9 * casadi.cos(q[1]) + 0.05 * casadi.sin(q[1])


@pytest.fixture
def written():
    """Written(T + more, V + more): the wrong pendulum with something added to its energies."""

    def make(kinetic=lambda q, qd: 0, potential=lambda q: 0):
        return Written(lambda q, qd: _kinetic(q, qd) + kinetic(q, qd), lambda q: _potential(q) + potential(q))

    return make


@pytest.fixture(scope="session")
def system():
    return load("sip")


@pytest.fixture(scope="session")
def data(system):
    return random_force(system, seeds=[0, 1], samples=600, episode_steps=100)


@pytest.fixture
def exact():
    """The T1 model with the coefficients of Table I, two members."""
    return Lagrangian(t1, 2), torch.tensor([TRUE_T1] * 2, dtype=torch.float64)


@pytest.fixture
def no_weights():
    return torch.zeros(2, 0, dtype=torch.float64)
