"""The gauge: what canonical and anchored readings take away, and what they must not."""

import casadi
import numpy as np
import pytest

from repro.codegen.array_evaluation import evaluate
from repro.evaluation.canonical import RestStates, in_gauge
from repro.evaluation.predictions import predict
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.gauge import Gauge

GAUGES = list(Gauge)
SPOILT = {
    "kinetic": lambda q, qd: 0.3 * casadi.sin(q[1]) + 2.0 + casadi.cos(q[1]) * qd[1] + 0.5 * qd[0],
    "potential": lambda q: -1.3,
}


def _read(model, reading, system, q, qd, no_weights):
    zero = np.zeros_like(q)
    said = predict(model, no_weights, q, qd, zero, zero)
    return in_gauge(said, RestStates(model, no_weights, system, q), qd, Gauge(reading))


@pytest.mark.parametrize("reading", ["canonical", "canonical_anchor"])
def test_canonical_kinetic_energy_vanishes_at_rest(reading, written, no_weights, data, system):
    q = data.test.q
    read = _read(written(**SPOILT), reading, system, q, np.zeros_like(q), no_weights)
    np.testing.assert_allclose(read.kinetic, 0, atol=1e-12)


def test_the_canonical_form_undoes_what_was_added(written, no_weights, data, system):
    """T~ is the T without additions; V~ holds f(theta) with the other sign, L~ is the same up to dF/dt."""
    q, qd = data.test.q, data.test.qd
    pure = _read(written(), "raw", system, q, qd, no_weights)
    read = _read(written(**SPOILT), "canonical", system, q, qd, no_weights)
    np.testing.assert_allclose(read.kinetic, pure.kinetic, atol=1e-10)
    np.testing.assert_allclose(read.potential, pure.potential - 1.3 - 0.3 * np.sin(q[..., 1]) - 2.0, atol=1e-12)


@pytest.mark.parametrize("reading", ["anchor", "canonical_anchor"])
@pytest.mark.parametrize("convention", ["physical", "printed"])
def test_the_anchor_gives_the_known_energy_at_the_upright_rest(reading, convention, written, no_weights):
    system = load("sip", convention)
    q = np.broadcast_to(system.at_rest("upright"), (2, 1, 2)).copy()
    read = _read(written(**SPOILT), reading, system, q, np.zeros_like(q), no_weights)
    known = evaluate(dynamics_of(system).hamiltonian, system.at_rest("upright"), np.zeros(2))[0]
    assert known == pytest.approx(0.98, rel=1e-12)
    np.testing.assert_allclose(read.kinetic + read.potential, known, atol=1e-12)


def test_without_an_anchor_a_constant_stays(written, no_weights, data, system):
    q, qd = data.test.q, data.test.qd
    for reading, stays in zip(GAUGES, [True, False, True, False], strict=True):
        pure, moved = (
            _read(written(potential=shift), reading, system, q, qd, no_weights).potential
            for shift in (lambda q: 0, lambda q: 5.0)
        )
        np.testing.assert_allclose(moved - pure, 5.0 if stays else 0.0, atol=1e-12)


def test_a_gradient_field_leaves_no_remainder(written, no_weights, data, system):
    model = written(kinetic=lambda q, qd: (casadi.cos(q[1]) + 3 * casadi.sin(3 * q[1]) - 1) * qd[1] + 0.4 * qd[0])
    np.testing.assert_allclose(RestStates(model, no_weights, system, data.test.q).remainder, 0, atol=1e-10)


def test_a_gyroscopic_force_is_the_remainder(written, no_weights, data, system):
    """a = (sin(theta), 0) has a curl: only its mean is a gradient (F linear in x)."""
    model = written(kinetic=lambda q, qd: casadi.sin(q[1]) * qd[0])
    curl = np.sin(data.test.q[..., 1])
    expected = 0.5 * np.abs(curl - curl.mean(1, keepdims=True)).mean(1)
    remainder = RestStates(model, no_weights, system, data.test.q).remainder
    np.testing.assert_allclose(remainder, expected, rtol=1e-9)
    assert np.all(expected > 0.1)
