"""Predictions in chunks, and the truth."""

from dataclasses import fields

import numpy as np
import pytest
import torch
from optional import needs_compiler

from repro.codegen import point_function
from repro.evaluation import predictions
from repro.evaluation.predictions import predict, truth
from repro.mechanics.system import load
from repro.models.bases import t1, t2
from repro.models.damped import Damped
from repro.models.kinds import blackbox, port_hamiltonian, structured
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian

STRUCTURED = Structured(2, np.array([0.9, 5.0]), structured.Options(hidden=(2,)))
MODELS = {
    "network": Lagrangian(t2, 2, hidden=(4,)),
    "structured": STRUCTURED,
    "damped, transformed": Damped(Lagrangian(t1, 2, momentum_hidden=(2,)), "full"),
    "port-Hamiltonian": PortHamiltonian(
        STRUCTURED, np.array([0.9, 5.0]), port_hamiltonian.Options(damping_hidden=(2,), floor=0.0)
    ),
    "black box": BlackBox(2, blackbox.Options(hidden=(3,))),
}


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


def test_only_a_chunk_of_the_samples_of_one_member_is_prepared_at_once(data, monkeypatch):
    model, prepared = Lagrangian(t2, 2, hidden=(4,)), []
    prepare = model.prepare
    monkeypatch.setattr(model, "prepare", lambda *arrays: prepared.append(arrays[0].shape) or prepare(*arrays))
    monkeypatch.setattr(predictions, "CHUNK", 250)
    weights = model.initial([np.random.default_rng(k) for k in range(data.members)])
    predict(model, weights, data.q, data.qd, data.qdd, data.tau)
    assert {shape[0] for shape in prepared} == {1} and max(shape[1] for shape in prepared) == 250
    assert sum(shape[1] for shape in prepared) == data.members * data.samples


@needs_compiler
@pytest.mark.parametrize("name", MODELS)
def test_compiled_predictions_are_those_of_torch(name, data, monkeypatch):
    model, members = MODELS[name], range(data.members)
    weights = model.initial([np.random.default_rng(k) for k in members])
    weights += 0.1 * np.random.default_rng(0).normal(size=weights.shape)
    arguments = (model, torch.from_numpy(weights), data.q, data.qd, data.qdd, data.tau)
    expected = predict(*arguments)
    for module in (predictions, point_function):
        monkeypatch.setattr(module, "LEAST_POINTS", 1)
    monkeypatch.setattr(point_function, "LEAST_WORK", 1)
    ours = predict(*arguments)
    for field in fields(expected):
        one, other = getattr(ours, field.name), getattr(expected, field.name)
        assert (one is None) == (other is None), field.name
        if one is not None:
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12 * np.abs(other).max())


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


def test_the_mass_of_one_coordinate_is_a_matrix():
    system, q = load("link"), np.ones((2, 3, 1))
    true = truth(system, q, 2 * q, q, q)
    assert true.mass.shape == (2, 3, 1, 1)
    np.testing.assert_allclose(true.mass[..., 0], true.momentum / 2)
