"""Coefficients and support of linear bases."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from repro.evaluation.coefficients import coefficient_errors, true_coefficients
from repro.mechanics.system import load
from repro.models.bases import fxf, library, t1
from repro.models.lagrangian import Lagrangian


@pytest.mark.parametrize(("name", "expected"), [("sip", [0.4, 0.025, 0.1]), ("sip_rod", [0.4, 1 / 120, 0.05])])
@pytest.mark.parametrize(("convention", "sign"), [("physical", 1), ("printed", -1)])
def test_the_true_coefficients_follow_from_table_1(name, expected, convention, sign):
    """(m0 + m1) / 2, (m1 l^2 + J) / 2, m1 l and m1 g l."""
    gravity = 0.2 * 9.8 * (0.5 if name == "sip" else 0.25)
    true = true_coefficients(Lagrangian(t1, 2), load(name, convention))
    np.testing.assert_allclose(true, [*expected, sign * gravity], rtol=1e-12)


def test_in_a_larger_basis_the_other_terms_are_exactly_zero(system):
    model = Lagrangian(library, 2)
    true = dict(zip(model.coefficient_names, true_coefficients(model, system), strict=True))
    kept = {name for name, value in true.items() if value != 0}
    assert kept == {"xd^2 thetad^0 1", "xd^0 thetad^2 1", "xd^1 thetad^1 cos(theta)", "cos(theta)"}


def test_a_basis_that_misses_a_term_has_no_true_coefficients(system, no_weights):
    partial = SimpleNamespace(LINEAR=True, kinetic=lambda q, qd, m: {"xd^2": qd[0] ** 2}, potential=t1.potential)
    model = Lagrangian(partial, 2)
    assert true_coefficients(model, system) is None
    assert list(coefficient_errors(model, no_weights, system)) == []


def test_errors_count_false_and_missing_terms(system):
    model = Lagrangian(library, 2)
    true = true_coefficients(model, system)
    members = np.stack([true, true, true, true])
    members[1, model.coefficient_names.index("x^2")] = 0.03
    members[2, model.coefficient_names.index("cos(theta)")] = 0.0
    members[3] += np.where(true != 0, 0.01, 0.0)
    errors = {m.name: m.values for m in coefficient_errors(model, torch.from_numpy(members), system)}
    np.testing.assert_array_equal(errors["false_terms"], [0, 1, 0, 0])
    np.testing.assert_array_equal(errors["missing_terms"], [0, 0, 1, 0])
    np.testing.assert_array_equal(errors["support_exact"], [1, 0, 0, 1])
    np.testing.assert_allclose(errors["coefficient_error"], [0, 0.03, 0.98, 0.01], atol=1e-12)


def test_identities_between_the_terms_are_no_error():
    """sin^2 + cos^2 = 1: any share of it may be added, and there is no one true support."""
    dip = load("dip")
    model = Lagrangian(fxf, 3)
    true, names = true_coefficients(model, dip), model.coefficient_names
    shifted = true.copy()
    for name, share in {"(theta1d sin(theta1))^2": 5, "(theta1d cos(theta1))^2": 5, "theta1d^2": -5}.items():
        shifted[names.index(name)] += share
    wrong = shifted.copy()
    wrong[names.index("cos(theta2)")] += 0.25
    errors = list(coefficient_errors(model, torch.from_numpy(np.stack([shifted, wrong])), dip))
    assert [error.name for error in errors] == ["coefficient_error"]
    np.testing.assert_allclose(errors[0].values, [0, 0.25], atol=1e-12)
