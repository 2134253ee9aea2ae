"""Predictions in chunks, and the truth."""

import numpy as np
import torch

from repro.evaluation import predictions
from repro.evaluation.predictions import predict, truth
from repro.models.bases import t2
from repro.models.lagrangian import Lagrangian


def test_chunks_change_nothing(data, monkeypatch):
    model = Lagrangian(t2, 2, hidden=(4,))
    parameters = torch.from_numpy(model.initial([np.random.default_rng(k) for k in range(2)]))
    arrays = (data.q, data.qd, data.qdd, data.tau)
    whole = predict(model, parameters, *arrays)
    monkeypatch.setattr(predictions, "CHUNK", 101)
    pieces = predict(model, parameters, *arrays)
    for name in ("tau", "acceleration", "momentum", "kinetic", "potential", "mass"):
        np.testing.assert_allclose(getattr(pieces, name), getattr(whole, name), rtol=1e-12, atol=1e-12)
    assert pieces.transformed_momentum is None


def test_single_precision_weights_predict_in_double(exact, data):
    model, parameters = exact
    said = predict(model, parameters.float(), data.q, data.qd, data.qdd, data.tau)
    assert said.tau.dtype == np.float64
    np.testing.assert_allclose(said.tau, data.tau, atol=1e-4)


def test_the_truth_obeys_its_own_definitions(data, system):
    true = truth(system, data.q, data.qd, data.qdd, data.tau)
    np.testing.assert_allclose(np.einsum("...ij,...j->...i", true.mass, data.qd), true.momentum, atol=1e-13)
    np.testing.assert_allclose(true.kinetic, 0.5 * (true.momentum * data.qd).sum(-1), atol=1e-13)
    np.testing.assert_allclose(true.hamiltonian(data.qd), true.kinetic + true.potential, atol=1e-13)
    np.testing.assert_allclose(true.potential, 0.98 * np.cos(data.q[..., 1]), atol=1e-13)
    inertial = np.einsum("...ij,...j->...i", true.mass, data.qdd)[..., 0]
    centrifugal = 0.1 * data.qd[..., 1] ** 2 * np.sin(data.q[..., 1])
    np.testing.assert_allclose(inertial, data.tau[..., 0] + centrifugal, atol=1e-11)
