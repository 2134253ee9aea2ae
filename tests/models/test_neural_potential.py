"""A body whose potential is a network: what it depends on, where it starts, and a spring that it learns."""

import numpy as np
import pytest
import torch
from simulated import random_force
from tensors import assert_close

from repro.learning.objective import Objective
from repro.learning.objectives import inverse
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import t1
from repro.models.context import Context
from repro.models.kinds import neural_potential
from repro.models.kinds.neural_potential import NeuralPotential
from repro.models.ports import ChainLink

LINK = load("link", damping=[0.3])


def _terms(model, weights, q, qd):
    zero = np.zeros_like(q)
    prepared = {name: torch.from_numpy(array) for name, array in model.prepare(q, qd, zero, zero).items()}
    return model.evaluate(torch.from_numpy(weights), prepared, mass=True)


@pytest.fixture
def rod():
    """x, y and an angle, with random weights."""
    model = NeuralPotential(np.array([1.0, 1.0, 5.0]), np.array([2.0, 0.5, 1.0]), [2], neural_potential.Options())
    return model, model.initial([np.random.default_rng(3)]) + 0.2


def test_the_mass_matrix_depends_on_angles_alone_and_the_potential_on_all(rod):
    model, weights = rod
    q = np.random.default_rng(1).normal(size=(1, 6, 3))
    here, moved = (_terms(model, weights, q + shift, q) for shift in (0.0, np.array([0.3, -0.2, 2 * np.pi])))
    assert_close(here.mass, moved.mass, rtol=1e-10, atol=1e-12)
    assert (here.potential - moved.potential).abs().min() > 1e-3
    assert torch.linalg.eigvalsh(here.mass).min() > 0


def test_it_starts_with_the_inertia_scale_of_the_data_and_no_energy_at_the_origin(rod):
    model, weights = rod
    start = model.initial([np.random.default_rng(k) for k in range(5)])
    q = np.zeros((5, 1, 3))
    mass = _terms(model, start, q, q).mass.numpy()
    scale = model.velocity_scale
    np.testing.assert_allclose(mass * np.outer(scale, scale), np.broadcast_to(np.eye(3), mass.shape), atol=0.6)
    assert _terms(model, weights, q[:1], q[:1]).potential.abs().max() == 0


def test_a_spring_is_learned_with_the_mass_and_the_damper():
    data = random_force(LINK, seeds=[0], samples=400, episode_steps=50, reset="random")
    context = Context(t1, LINK.coordinates, data.q, data.qd, data.train.qd, LINK)
    model = neural_potential.build(context, neural_potential.Options(hidden=(4,), damping="diagonal"))
    problem = TrainingProblem(model, [make_task(model, data.train, Objective(inverse.Options()))], [0])
    start = torch.from_numpy(model.initial([np.random.default_rng(0)]))
    found = LevenbergMarquardt(restarts=1, iterations=150).fit(problem, start, silent, NoCheckpoint())
    link = ChainLink.learned(model, found.parameters[0].numpy())
    assert link.mass == pytest.approx(LINK.m1, rel=1e-3)
    assert link.damping == pytest.approx(0.3, rel=1e-2)
