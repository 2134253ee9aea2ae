"""The paper's F (x) F: what it holds, for any number of links."""

import numpy as np
import pytest

from repro.evaluation.coefficients import true_coefficients
from repro.mechanics.system import load
from repro.models.bases import fxf, fxf_gauge
from repro.models.lagrangian import Lagrangian


def _drawn(n_q, seed=0):
    generator = np.random.default_rng(seed)
    return list(generator.normal(size=n_q)), list(generator.normal(size=n_q))


@pytest.mark.parametrize(("n_q", "distinct"), [(2, 10), (3, 28), (4, 55)])
def test_it_holds_the_kronecker_product_without_repetition(n_q, distinct):
    q, qd = _drawn(n_q)
    factors = np.array([*fxf.factors(q, qd, np).values()])
    products = np.array([*fxf.kinetic(q, qd, np).values()])
    assert len(products) == distinct
    np.testing.assert_allclose(np.unique(products), np.unique(np.kron(factors, factors).round(14)), atol=1e-12)


def test_the_factors_of_the_double_pendulum_are_those_of_the_paper():
    (_, a, b), (xd, ad, bd) = q, qd = _drawn(3)
    printed = [xd, ad * np.sin(a), ad * np.cos(a), bd * np.sin(b), bd * np.cos(b), ad, bd]
    np.testing.assert_array_equal([*fxf.factors(q, qd, np).values()], printed)


@pytest.mark.parametrize("system", [load("dip"), load("sip"), load("sip_rod"), load("cart_rods", n=4)])
def test_the_true_lagrangian_is_in_its_span(system):
    assert true_coefficients(Lagrangian(fxf, system.n_q), system) is not None


def test_a_misprinted_kinetic_energy_is_in_its_span_too_and_the_misprinted_potential_is_not():
    """So a fit of T would not reveal the misprint."""
    physical, printed = load("dip"), load("dip", "printed")
    model = Lagrangian(fxf, 3)
    assert true_coefficients(model, printed) is None
    q, qd = np.random.default_rng(0).normal(size=(2, 200, 3))
    columns = model.kinetic_features.jets(q, qd, np.zeros_like(q))[..., 0, :]
    for system in (physical, printed):
        energy = system.kinetic(q.T, qd.T, np)
        solution = np.linalg.lstsq(columns, energy, rcond=None)[0]
        np.testing.assert_allclose(columns @ solution, energy, atol=1e-12)


def test_the_gauge_terms_do_not_show_in_the_forces():
    model = Lagrangian(fxf_gauge, 3)
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, 1, 50, 3))
    rows = model.prepare(q, qd, qdd, np.zeros_like(q))["kinetic"][..., 2 + 3 : 2 + 2 * 3, :]
    names = model.kinetic_features.names
    unseen = [names.index(name) for name in ("1", *fxf.factors(q[0, 0], qd[0, 0], np))]
    assert np.abs(rows[..., unseen]).max() < 1e-14
    seen = [index for index in range(len(names)) if index not in unseen]
    assert np.abs(rows[..., seen]).max((0, 1, 2)).min() > 1e-3
