"""Power by hand."""

import numpy as np

from repro.evaluation.power_balance import power_balance, supplied_power

TIME = np.array([0.0, 0.5, 1.5])
Q = np.array([[0.0, 1.0], [1.0, 1.0], [2.0, -1.0]])
TAU = np.array([[2.0, 5.0], [3.0, 0.5], [9.0, 9.0]])


def test_every_component_supplies_power_over_its_step():
    np.testing.assert_allclose(supplied_power(Q, TAU, TIME), [2.0 * 1.0 / 0.5, (3.0 * 1.0 - 0.5 * 2.0) / 1.0])
    np.testing.assert_array_equal(supplied_power(Q[None], TAU[None], TIME)[0], supplied_power(Q, TAU, TIME))


def test_what_is_not_stored_is_dissipated():
    balance = power_balance(Q, TAU, np.array([0.0, 1.5, 3.0]), TIME)
    np.testing.assert_allclose(balance["dH/dt"], [3.0, 1.5, 0.0])
    np.testing.assert_allclose(balance["dissipated"], [1.0, 0.5, 0.0])
