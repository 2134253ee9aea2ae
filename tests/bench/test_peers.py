"""Peers compute the same numbers, and are left out where they are not installed."""

from importlib.util import find_spec

import numpy as np
import pytest

from repro.bench import peers as module
from repro.bench.case import lagrangian_case
from repro.bench.jax_peer import jax_step
from repro.bench.peers import peers
from repro.bench.scale import SCALES
from repro.bench.step import torch_step
from repro.models.bases import t2


@pytest.mark.extras
@pytest.mark.skipif(find_spec("jax") is None, reason="needs the extra `peers`")
@pytest.mark.parametrize("equation", ["inverse", "forward"])
def test_jax_agrees_with_our_engine(equation):
    case = lagrangian_case(t2, (6, 5), 2, 40)
    for ours, other in zip(torch_step(case, equation)(), jax_step(case, equation)(), strict=True):
        np.testing.assert_allclose(other, ours, rtol=0, atol=1e-9 * np.abs(ours).max())


def test_a_peer_that_is_not_installed_is_left_out(monkeypatch):
    monkeypatch.setattr(module, "_version", lambda package: None)
    assert list(peers(SCALES["smoke"])) == []


def test_the_protocol_names_the_version_of_the_peer(monkeypatch):
    monkeypatch.setattr(module, "_version", lambda package: "9.8.7" if package == "jax" else None)
    found = list(peers(SCALES["quick"]))
    assert {comparison.members for comparison in found} == {1, 10}
    assert all("JAX 9.8.7" in comparison.protocol for comparison in found)
