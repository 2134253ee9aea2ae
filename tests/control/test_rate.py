"""Accelerations and their derivatives against those that CasADi finds by differentiating the forward dynamics."""

import casadi as ca
import numpy as np
import pytest

from repro.control.predictive_model import PredictiveModel
from repro.control.rate import Rate
from repro.mechanics.system import load
from repro.models.bases import fxf, library, t1, t2
from repro.models.kinds import neural_potential, port_hamiltonian, structured
from repro.models.kinds.neural_potential import NeuralPotential
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.kinds.structured import Structured
from repro.models.kinds.truth import DampedTruth, Truth
from repro.models.lagrangian import Lagrangian

SIP, DIP = np.array([0.9, 5.0]), np.array([0.9, 5.0, 6.0])
MODELS = {
    "sip t1": lambda system: Lagrangian(t1, 2),
    "sip library": lambda system: Lagrangian(library, 2),
    "sip t2": lambda system: Lagrangian(t2, 2, hidden=(4,)),
    "sip structured": lambda system: Structured(2, SIP, structured.Options(hidden=(4,))),
    "sip port": lambda system: PortHamiltonian(
        Structured(2, SIP, structured.Options(hidden=(3,))),
        SIP,
        port_hamiltonian.Options(structure="free", damping_hidden=(2,), floor=0.0),
    ),
    "dip truth": Truth,
    "dip damped": DampedTruth,
    "dip fxf": lambda system: Lagrangian(fxf, 3),
    "dip structured": lambda system: Structured(3, DIP, structured.Options(hidden=(2,))),
    "quadrotor network": lambda system: NeuralPotential(
        np.ones(3), np.ones(3), (2,), neural_potential.Options(hidden=(2,))
    ),
    "acrobot network": lambda system: NeuralPotential(
        np.ones(2), np.ones(2), (0, 1), neural_potential.Options(hidden=(2,))
    ),
}


@pytest.mark.parametrize("name", MODELS)
def test_derivatives_are_those_of_the_forward_dynamics(name):
    system = load(name.split()[0])
    model = PredictiveModel(MODELS[name](system), system)
    generator = np.random.default_rng(3)
    (weights,) = model.model.initial([generator])
    n_q, rate = system.n_q, Rate(model)
    n_z = 2 * n_q + len(system.inputs)
    z, w, multipliers = ca.SX.sym("z", n_z), ca.SX.sym("w", len(weights)), ca.SX.sym("lambda", n_q)
    qdd = model.derivative(z[: 2 * n_q], z[2 * n_q :], w)[n_q:]
    slopes = ca.jacobian(qdd, z)
    hessian = ca.jacobian(ca.mtimes(slopes.T, multipliers), z)
    expected = ca.Function("expected", [z, w, multipliers], [qdd, slopes, hessian])
    for _ in range(3):
        point, combination = generator.normal(size=n_z), generator.normal(size=n_q)
        value, first, second = (np.asarray(part) for part in expected(point, weights, combination))
        jacobian = np.asarray(rate.jacobian(point, weights)).ravel()
        curvature = np.asarray(rate.hessian(point, weights, jacobian, combination)).reshape(second.shape)
        _agree(np.asarray(rate.value(point, weights)), value)
        _agree(jacobian, np.concatenate([value.ravel(), first.ravel()]))
        _agree(curvature, second)


def _agree(ours, expected):
    np.testing.assert_allclose(ours, expected, rtol=1e-8, atol=1e-9 * (1 + np.abs(expected).max()))
