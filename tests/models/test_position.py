"""Position features by the kind of each coordinate, and what models learn of a body with two translations."""

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.evaluation.predictions import predict
from repro.learning.objective import Objective
from repro.learning.objectives import inverse
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.chain import Chain
from repro.mechanics.system import load
from repro.mechanics.system_options import SYSTEMS
from repro.models.bases import raw
from repro.models.context import Context
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured
from repro.models.position import cart_with_links, position_features
from repro.plugins.plugin import plugin_names

ROD = load("rod")


@pytest.mark.parametrize("name", [name for name in plugin_names(SYSTEMS) if isinstance(load(name), Chain)])
def test_a_cart_with_links_shows_its_angles_alone(name):
    system = load(name)
    assert position_features(system.coordinates, np.full(system.n_q, 3.0)) == cart_with_links(system.n_q)


def test_a_cyclic_angle_is_not_shown_and_cosines_do_for_angles_from_the_vertical_alone():
    shown = {name: position_features(load(name).coordinates) for name in plugin_names(SYSTEMS)}
    assert shown["furuta"].angles == (1,)
    by_cosines = {name for name, features in shown.items() if features.upright_angles}
    assert by_cosines == {
        *("acrobot", "cart_rods", "dip", "furuta", "motor_pendulum", "pendubot", "sip", "sip_rod", "torque_pendulum")
    }


def test_a_translation_that_forces_depend_on_is_shown_in_its_scale():
    features = position_features(ROD.coordinates, np.array([5.0, 2.0, 1.0]))
    q = [0.3, 0.8, 0.5]
    assert features.inertia(q, q, np) == {"cos(q2)": np.cos(0.5), "sin(q2)": np.sin(0.5), "q1": 0.4}
    assert features.potential(q, q, np) == {"cos(q2)": np.cos(0.5), "q1": 0.4}


def test_a_structured_model_learns_a_free_rod_and_its_weight():
    data = random_force(ROD, seeds=[0], samples=400, episode_steps=50, reset="random")
    train = data.train
    context = Context(raw, data.coordinates, train.q, train.qd, train.qd, ROD)
    options = structured.Options(hidden=(8,), potential="cosines")
    model = Structured(3, context.velocity_scale, options, context.positions)
    problem = TrainingProblem(model, [make_task(model, train, Objective(inverse.Options()))], [0])
    start = torch.from_numpy(model.initial([np.random.default_rng(0)]))
    fitted = LevenbergMarquardt(iterations=40).fit(problem, start, silent, NoCheckpoint())
    test = data.test
    predicted = predict(model, fitted.parameters, test.q, test.qd, test.qdd, test.tau)
    assert np.abs(predicted.tau - test.tau).mean() < 0.05
    weight = model.potential_features.names.index("q1")
    slope = fitted.parameters[0, model.potential_slice][weight].item() / context.position_scale[1]
    assert slope == pytest.approx(0.2 * 9.8, rel=0.05)
