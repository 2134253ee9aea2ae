"""The classical comparator: its regulator holds, and it swings one link up."""

import numpy as np
import pytest
from cart_task import erect, hanging_start

from repro.control.closed_loop import run_loop
from repro.control.conditions import Conditions, Start
from repro.control.controllers.energy_shaping import EnergyShaping
from repro.errors import UserError
from repro.mechanics.system import load


@pytest.mark.parametrize("name", ["sip", "sip_rod"])
def test_it_swings_up_and_goes_to_the_place(name):
    system = load(name)
    start = hanging_start(system, 0.8)
    loop = run_loop(system, EnergyShaping(system, 0.8), start, Conditions(), time_step=0.04, seconds=8.0, disc=None)
    assert loop.outcome.success and np.abs(loop.inputs).max() <= 4.0


def test_the_regulator_holds_near_upright():
    system = load("sip", "printed")
    start = Start("near", np.array([0.5, np.pi + 0.1, 0.0, 0.0]), erect(system, 0.5), (0,))
    loop = run_loop(system, EnergyShaping(system, 0.5), start, Conditions(), time_step=0.04, seconds=6.0, disc=None)
    assert loop.outcome.success
    assert np.abs(loop.states[:, 1] - np.pi).max() < 0.3


def test_two_links_are_refused():
    with pytest.raises(UserError, match="a cart with one link; dip has 2"):
        EnergyShaping(load("dip"), 0.8)
