"""A learned model in the controller against torch: energies, their derivatives, and both directions of the dynamics."""

import casadi as ca
import numpy as np
import pytest
import torch

from repro.control.predictive_model import PredictiveModel
from repro.models.bases import engineered, library, raw, t1, t2
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured
from repro.models.kinds.truth import Truth
from repro.models.lagrangian import Lagrangian

SCALE = np.array([0.9, 5.0])
MODELS = {
    "t1": lambda system: Lagrangian(t1, 2),
    "library": lambda system: Lagrangian(library, 2),
    "t2": lambda system: Lagrangian(t2, 2, hidden=(10,)),
    "raw": lambda system: Lagrangian(raw, 2, hidden=(5,)),
    "engineered": lambda system: Lagrangian(engineered, 2, hidden=(4, 3), activation="tanh"),
    "structured": lambda system: Structured(2, SCALE, structured.Options(hidden=(8,))),
    "truth": Truth,
}


@pytest.fixture(params=MODELS)
def model(request, system):
    return MODELS[request.param](system)


def test_value_gradient_and_hessian_agree_with_torch(model, system):
    samples = {name: np.random.default_rng(1).normal(size=(1, 9, 2)) for name in ("q", "qd", "qdd", "tau")}
    weights = model.initial([np.random.default_rng(0)])
    prepared = {name: torch.from_numpy(array) for name, array in model.prepare(**samples).items()}
    terms = model.evaluate(torch.from_numpy(weights), prepared, mass=True)
    predictive = PredictiveModel(model, system, canonical=False)
    q, qd, qdd = (ca.SX.sym(name, 2) for name in ("q", "qd", "qdd"))
    bound = ca.SX(ca.DM(weights[0]))
    said = predictive.energies(q, qd, bound)
    exported = ca.Function(
        "exported",
        [q, qd, qdd],
        [
            said.kinetic,
            said.potential,
            ca.gradient(said.kinetic, qd),
            ca.hessian(said.kinetic, qd)[0],
            predictive.inverse(ca.vertcat(q, qd), qdd, 0, bound),
        ],
    )
    expected = [terms.kinetic, terms.potential, terms.momentum, terms.mass, terms.tau]
    for k in range(9):
        found = exported(*(samples[name][0, k] for name in ("q", "qd", "qdd")))
        for ours, theirs in zip(found, expected, strict=True):
            value = theirs[0, k].numpy()
            np.testing.assert_allclose(np.asarray(ours).reshape(value.shape), value, rtol=1e-9, atol=1e-9)


def test_forward_and_inverse_model_are_each_others_inverse(model, system):
    generator = np.random.default_rng(2)
    weights = ca.SX(ca.DM(model.initial([generator])[0]))
    x, f = ca.SX.sym("x", 4), ca.SX.sym("f")
    predictive = PredictiveModel(model, system)
    qdd = predictive.derivative(x, f, weights)[2:]
    residual = ca.Function("residual", [x, f], [predictive.inverse(x, qdd, f, weights), qdd])
    for _ in range(5):
        error, size = residual(generator.normal(size=4), 1.3)
        assert np.abs(np.asarray(error)).max() < 1e-8 * (1 + np.abs(np.asarray(size)).max())


def test_in_the_canonical_gauge_the_kinetic_energy_is_least_at_rest(system):
    model = Lagrangian(t2, 2, hidden=(6,))
    weights = ca.SX(ca.DM(model.initial([np.random.default_rng(0)])[0]))
    q, qd = ca.SX.sym("q", 2), ca.SX.sym("qd", 2)
    raw_energies, fixed = (PredictiveModel(model, system, kind).energies(q, qd, weights) for kind in (False, True))
    at_rest = ca.Function("at_rest", [q, qd], [fixed.kinetic, ca.gradient(fixed.kinetic, qd), raw_energies.kinetic])
    q_value = np.array([0.3, 1.1])
    kinetic, momentum, before = at_rest(q_value, np.zeros(2))
    assert abs(float(kinetic)) < 1e-14 and np.abs(np.asarray(momentum)).max() < 1e-14 and abs(float(before)) > 1e-3
    forces = [
        ca.Function("force", [q], [ca.substitute(ca.gradient(e.kinetic - e.potential, q), qd, 0)])(q_value)
        for e in (raw_energies, fixed)
    ]
    np.testing.assert_allclose(np.asarray(forces[0]), np.asarray(forces[1]), atol=1e-12)


def test_the_potential_cost_is_least_where_the_reading_says(system, truth):
    from repro.mechanics.system import load

    q, qd = ca.SX.sym("q", 2), ca.SX.sym("qd", 2)
    for reading, least in (("physical", 0.0), ("printed", 0.0)):
        chosen = load("sip", reading)
        model = PredictiveModel(Truth(chosen), chosen)
        said = model.energies(q, qd, ca.SX(ca.DM(model.model.coefficients)))
        cost = ca.Function("cost", [q, qd], [model.potential_cost(said.potential)])
        assert float(cost([0, least], [0, 0])) < float(cost([0, least + np.pi], [0, 0]))
