"""Success as a predicate on constructed trajectories."""

import numpy as np
import pytest
from cart_task import erect

from repro.control.goal import judge
from repro.mechanics.system import load

DIP = load("dip")
TIME = np.arange(0, 10.0001, 0.005)
X_DES = 0.8


def trajectory(erect_from=5.0):
    states = np.zeros((len(TIME), 6))
    states[:, 0] = X_DES
    states[erect_from - TIME > 1e-9, 1] = 1.0
    return states


def outcome(states, clearance=None):
    return judge(TIME, states, np.full(len(TIME), 0.1) if clearance is None else clearance, erect(DIP, X_DES))


def test_erect_from_five_seconds_on_is_success():
    found = outcome(trajectory())
    assert found.success and not found.contact
    assert found.held_from == pytest.approx(5.0)
    assert (found.clearance, found.steady_error) == (0.1, 0.0)


@pytest.mark.parametrize(("since", "success"), [(8.0, True), (8.005, False), (10.0, False)])
def test_all_of_the_last_two_seconds_counts(since, success):
    assert outcome(trajectory(since)).success is success


def test_one_bad_sub_step_is_failure():
    states = trajectory()
    states[-100, 2] = np.deg2rad(5.1)
    assert not outcome(states).success
    states[-100, 2] = np.deg2rad(4.9)
    assert outcome(states).success
    states[-1, 0] = X_DES + 0.051
    found = outcome(states)
    assert not found.success and np.isnan(found.held_from)


def test_angles_count_modulo_a_turn():
    states = trajectory()
    states[:, 1] += 4 * np.pi
    states[:, 2] -= 2 * np.pi - np.deg2rad(1)
    assert outcome(states).success
    states[:, 2] += np.pi
    assert not outcome(states).success


def test_a_contact_at_any_time_is_failure():
    clearance = np.full(len(TIME), 0.1)
    clearance[3] = -1e-6
    found = outcome(trajectory(), clearance)
    assert found.contact and not found.success and found.held_from == pytest.approx(5.0)
    assert judge(TIME, trajectory(), None, erect(DIP, X_DES)).success, "without a disc there is nothing to touch"


def test_a_loop_given_up_is_failure():
    states = trajectory()
    states[1500:] = np.nan
    clearance = np.full(len(TIME), 0.1)
    clearance[1500:] = np.nan
    found = outcome(states, clearance)
    assert not found.success and not found.contact and np.isnan(found.held_from) and found.clearance == 0.1


def test_upright_depends_on_the_reading():
    printed = load("sip", "printed")
    assert erect(printed, 0.0).reached(np.array([0.0, np.pi, 0, 0]))
    assert not erect(printed, 0.0).reached(np.zeros(4))
    assert erect(load("sip"), 0.0).reached(np.zeros(4))
