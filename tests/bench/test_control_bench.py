"""Our controller beside do-mpc's: the same problem, so the same plan; and what the timing of a step counts."""

import numpy as np
import pytest
from optional import needs_extra

from repro.bench.control import CASES, EQUAL, FAST, control
from repro.bench.do_mpc_peer import Collocation
from repro.bench.scale import SCALES
from repro.control.interval import DEGREE, ELEMENTS

SIP, DIP = CASES
pytestmark = [pytest.mark.extras, pytest.mark.filterwarnings("ignore"), needs_extra("peers", "do_mpc")]
NEAR = np.array([0.6, 0.3, 0.2, -0.5])  # nearly there: one optimum only


def _their_plan(case, collocation, state):
    peer = case.theirs(collocation)
    peer.start(state)
    assert peer.force(state) == pytest.approx(peer.plan[1][0, 0])
    return peer.plan


@pytest.mark.parametrize("implicit", [True, False])
def test_both_find_the_same_plan(implicit):
    ours = SIP.ours(EQUAL).decide(NEAR)
    states, forces = _their_plan(SIP, Collocation(DEGREE, ELEMENTS, implicit), NEAR)
    assert ours.u == pytest.approx(forces[0], abs=1e-3)
    early = slice(0, 9)  # the end of the plan costs nearly nothing, and is found as loosely as the tolerance allows
    np.testing.assert_allclose(states[early], ours.plan[early], atol=2e-3)


def test_each_is_accurate_in_its_own_discretisation():
    states, forces = _their_plan(SIP, SIP.collocation, NEAR)
    controller = SIP.ours(FAST)
    controller.decide(NEAR)
    controller.solver.close()
    assert SIP.state_error(states, forces) < 1e-2
    assert SIP.state_error(controller.plan.states, controller.plan.inputs) < 1e-2


def test_the_limits_of_force_and_speed_are_kept():
    states, forces = _their_plan(DIP, Collocation(2, 1), np.array([0.0, np.pi - 0.3, np.pi + 0.2, 0.0, 0.0, 0.0]))
    assert np.abs(forces).max() == pytest.approx(DIP.problem.force_limit, rel=1e-3)
    assert np.abs(states[:, 3:]).max() < DIP.problem.speed_limit


def test_the_rows_say_how_each_discretises():
    rows = list(control(SCALES["smoke"], "9.8.7"))
    assert [row.size for row in rows] == ["SIP, 20 intervals"] * 2 + ["DIP, 30 intervals"] * 2
    assert all("do-mpc 9.8.7" in row.protocol for row in rows)
    assert rows[1].ours.endswith("Radau 2 x 2") and rows[1].other.endswith("Radau 2 x 2")
