"""Peers compute the same numbers, and are left out where they are not installed."""

import numpy as np
import pytest
from optional import compares_with

from repro.bench import peers as module
from repro.bench.framework_peers import jax_batched_step, jax_step
from repro.bench.peers import implicit_candidates, peers, phlearn_step, selection_fit, sindy_pi_fit
from repro.bench.scale import SCALES
from repro.bench.training_case import network, pendulum_case, torch_step
from repro.models.bases import library, t2
from repro.models.lagrangian import Lagrangian


@compares_with("jax")
@pytest.mark.parametrize("equation", ["inverse", "forward"])
def test_jax_agrees_with_our_engine(equation):
    case = pendulum_case(network(t2, (6, 5)), 2, 40)
    for ours, other in zip(torch_step(case, equation)(), jax_step(case, equation)(), strict=True):
        np.testing.assert_allclose(other, ours, rtol=0, atol=1e-9 * np.abs(ours).max())


@compares_with("jax")
@pytest.mark.parametrize(("precision", "close"), [("float64", 1e-9), ("float32", 1e-4)])
def test_the_batched_form_in_jax_agrees_with_our_engine(precision, close):
    case = pendulum_case(network(t2, (6, 5)), 1, 40)
    for ours, other in zip(torch_step(case, "inverse")(), jax_batched_step(case, precision)(), strict=True):
        np.testing.assert_allclose(other, ours, rtol=0, atol=close * np.abs(ours).max())


@compares_with("pysindy")
def test_sindy_pi_finds_the_accelerations_that_we_find():
    candidates, (cart, pole) = implicit_candidates(2048), sindy_pi_fit(2048)()
    for column, row in enumerate((cart, pole)):
        assert np.abs(candidates @ row - candidates[:, column]).mean() < 1e-6


def test_our_selection_finds_the_terms_of_the_lagrangian():
    found, names = selection_fit(2048)(), Lagrangian(library, 2).coefficient_names
    kept = {names[index]: value for index, value in enumerate(found) if value}
    expected = {"xd^2 thetad^0 1": 0.4, "xd^1 thetad^1 cos(theta)": 0.1, "xd^0 thetad^2 1": 0.025, "cos(theta)": 0.98}
    assert kept == pytest.approx(expected, rel=1e-9)


@compares_with("phlearn")
def test_phlearn_gives_a_gradient_of_every_weight_that_matters():
    loss, gradient = phlearn_step(pendulum_case(network(t2, (4,)), 1, 30))()
    assert loss > 0 and gradient[-1] == 0 and np.abs(gradient[:-1]).max() > 0


def test_a_peer_that_is_not_installed_is_left_out(monkeypatch):
    monkeypatch.setattr(module, "_version", lambda package: None)
    assert list(peers(SCALES["smoke"])) == []
    assert all("torch.compile" in comparison.other for comparison in peers(SCALES["paper"]))


def test_the_protocol_names_the_version_of_the_peer(monkeypatch):
    monkeypatch.setattr(module, "_version", lambda package: "9.8.7" if package == "jax" else None)
    found = [comparison for comparison in peers(SCALES["quick"]) if "torch" not in comparison.other]
    assert {comparison.members for comparison in found} == {1, 10}
    assert all("JAX 9.8.7" in comparison.protocol + comparison.other for comparison in found)
