"""A Hamiltonian network trained by phlearn, on a spring as its package makes it, and the same one trained here.

The mass is 1, so that momenta are velocities; both are given the exact rates of the states and the same first weights.
"""

from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
import pytest
import torch
from optional import compares_with
from torch import nn

import repro
from repro.data.dataset import Dataset
from repro.learning.native import shuffled
from repro.learning.objective import Objective
from repro.learning.objectives import port
from repro.learning.optimisers.adam import Adam
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.kinds import hamiltonian
from repro.models.kinds.hamiltonian import Hamiltonian
from repro.models.position import PositionFeatures

if TYPE_CHECKING:
    from phlearn.phnns import PseudoHamiltonianNN

SPRING = load("spring_row", n=1, m1=1.0, k1=1.0)
DAMPING = 0.3  # N s/m, as in the examples of the package
SEED = 0


@dataclass(frozen=True)
class Recipe:
    """points: for training, as many again held out; rate: of learning; seconds, step: of a trajectory."""

    hidden: tuple[int, int]
    points: int
    epochs: int
    batch: int
    damping: float
    rate: float = 1e-3
    seconds: float = 1.0
    step: float = 1 / 30


def generated(recipe: Recipe, seed: int) -> tuple[list[torch.Tensor], torch.Tensor]:
    """States and their exact rates by the generator of the package."""
    from phlearn.phnns import generate_dataset, npoints_to_ntrajectories_tsample
    from phlearn.phsystems.ode import MassSpringDamperSystem, initial_condition_radial

    plant = MassSpringDamperSystem(damping=recipe.damping, init_sampler=initial_condition_radial(1, 4.5))
    count, times = npoints_to_ntrajectories_tsample(recipe.points, recipe.seconds, recipe.step)
    options = {"true_derivatives": True, "nsamples": recipe.points, "seed": seed, "ttype": torch.float64}
    return generate_dataset(plant, count, times, **options)


def as_dataset(recipe: Recipe, made: tuple[list[torch.Tensor], torch.Tensor]) -> Dataset:
    state, rate = made[0][0].numpy(), made[1].numpy()
    arrays = {"q": state[:, :1], "qd": rate[:, :1], "qdd": rate[:, 1:], "tau": np.zeros((len(state), 1))}
    return repro.dataset(**arrays, time_step=recipe.step, coordinates=["x1"])


class Ours:
    """The model of model=hamiltonian on raw (q, p), fitted with objective=port and optimiser=adam."""

    def __init__(self, recipe: Recipe) -> None:
        self.recipe = recipe
        raw = PositionFeatures((), ((0, 1.0),))
        dissipation = "constant" if recipe.damping > 0 else "none"
        options = hamiltonian.Options(hidden=recipe.hidden, dissipation=dissipation)
        self.model = Hamiltonian(SPRING, raw, np.ones(1), options)
        self.weights = torch.from_numpy(self.model.initial([np.random.default_rng(SEED)]))

    def fit(self, data: Dataset) -> None:
        task = make_task(self.model, data, Objective(port.Options()))
        problem = TrainingProblem(self.model, [task], (SEED,))
        options = {"epochs": self.recipe.epochs, "batch_size": self.recipe.batch, "learning_rate": self.recipe.rate}
        adam = Adam(**options, decay=0.0, epsilon=1e-12)
        self.weights = torch.as_tensor(adam.fit(problem, self.weights, silent, NoCheckpoint()).parameters)

    def rates(self, data: Dataset) -> np.ndarray:
        return self.model.state_rate(self.weights, np.concatenate([data.q, data.qd], -1), data.tau)[0]

    @property
    def friction(self) -> float:
        return float(self.weights[0, self.model.damping_slice] ** 2)


def theirs(recipe: Recipe, start: Ours) -> "PseudoHamiltonianNN":
    """The model of the package, around a network with the weights from which ours starts."""
    from phlearn.phnns import PseudoHamiltonianNN, R_estimator

    network = start.model.network
    layers = [nn.Linear(*shape[::-1], dtype=torch.float64) for shape in network.shapes[::2]]
    arrays = network.unpack(start.weights[:, start.model.network_slice])
    for layer, weight, bias in zip(layers, arrays[::2], arrays[1::2], strict=True):
        layer.load_state_dict({"weight": weight[0], "bias": bias[0]})
    energy = nn.Sequential(layers[0], nn.Tanh(), layers[1], nn.Tanh(), layers[2])
    if recipe.damping:
        friction = R_estimator([False, True], torch.float64)
        friction.pick_rs = friction.pick_rs.double()
        friction.rs.data += start.friction
        return PseudoHamiltonianNN(2, hamiltonian_est=energy, dissipation_est=friction, ttype=torch.float64)
    return PseudoHamiltonianNN(2, hamiltonian_est=energy, dissipation_true=np.zeros((2, 2)), ttype=torch.float64)


def trained(recipe: Recipe, model: "PseudoHamiltonianNN", made: tuple[list[torch.Tensor], torch.Tensor]) -> None:
    """By the trainer of the package, its batches in the order of ours: the error of the last step depends on it."""
    from phlearn.phnns import train

    adam = torch.optim.Adam(model.parameters(), lr=recipe.rate, eps=1e-12)
    epochs = chain([0], range(recipe.epochs))  # it draws once before the first epoch
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(torch, "randperm", lambda count: torch.from_numpy(shuffled(SEED, count, next(epochs))).long())
        train(model, False, made, adam, epochs=recipe.epochs, batch_size=recipe.batch, verbose=False)


def predicted(model: "PseudoHamiltonianNN", made: tuple[list[torch.Tensor], torch.Tensor]) -> np.ndarray:
    return model.time_derivative(False, *made[0]).detach().numpy()


@compares_with("phlearn")
def test_both_take_the_same_steps() -> None:
    recipe = Recipe((20, 20), points=300, epochs=50, batch=64, damping=0.0, rate=0.01)
    made, held_out = generated(recipe, 0), generated(recipe, 1)
    ours = Ours(recipe)
    peer = theirs(recipe, ours)
    before = np.abs(predicted(peer, held_out) - held_out[1].numpy()).mean()
    trained(recipe, peer, made)
    ours.fit(as_dataset(recipe, made))
    rates = predicted(peer, held_out)
    assert np.abs(rates - held_out[1].numpy()).mean() < before / 2
    np.testing.assert_allclose(ours.rates(as_dataset(recipe, held_out)), rates, atol=1e-8 * np.abs(rates).max())


@pytest.mark.slow
@compares_with("phlearn")
def test_both_reach_the_same_error_by_the_recipe_of_the_package() -> None:
    """Its train_model.py: 3,000 points at 30 Hz, two layers of 100 units, batches of 32, 100 epochs of Adam at 1e-3."""
    recipe = Recipe((100, 100), points=3000, epochs=100, batch=32, damping=DAMPING)
    made, held_out = generated(recipe, 0), generated(recipe, 1)
    ours = Ours(recipe)
    peer = theirs(recipe, ours)
    trained(recipe, peer, made)
    ours.fit(as_dataset(recipe, made))
    both = ours.rates(as_dataset(recipe, held_out)), predicted(peer, held_out)
    errors = [((rates - held_out[1].numpy()) ** 2).mean() for rates in both]
    assert max(errors) < 2 * min(errors)
    np.testing.assert_allclose([ours.friction, float(peer.R().diagonal()[1])], DAMPING, rtol=0.02)
