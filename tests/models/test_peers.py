"""Models of the literature: their gradients, their mechanics, and what they find where it is known."""

import numpy as np
import pytest
import torch
from simulated import random_force
from tensors import assert_close

from repro.evaluation.model_motion import model_motion
from repro.evaluation.predictions import predict
from repro.learning.objective import Objective
from repro.learning.objectives import implicit
from repro.learning.optimisers.basis_selection import Selection
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.kinds import hamiltonian, sparse, symoden
from repro.models.kinds.hamiltonian import Hamiltonian, momentum_spread
from repro.models.kinds.sparse import Sparse
from repro.models.kinds.symoden import SymODEN
from repro.models.position import position_features

DIP = load("dip")
DATA = random_force(DIP, seeds=(0, 1), samples=40, reset="random", episode_steps=10, train_fraction=0.5)
SAMPLES = DATA.q, DATA.qd, DATA.qdd, DATA.tau
POSITIONS = position_features(DIP.coordinates)
MODELS = {
    "hamiltonian": lambda: Hamiltonian(
        DIP,
        POSITIONS,
        momentum_spread(DIP, DATA.q, DATA.qd),
        hamiltonian.Options(hidden=(6, 5), dissipation="constant"),
    ),
    "symoden": lambda: SymODEN(3, POSITIONS, symoden.Options(hidden=(6,), dissipation="state")),
    "sparse": lambda: Sparse(3, POSITIONS, sparse.Options(order=1, form="implicit")),
}


def _made(name):
    model = MODELS[name]()
    start = model.initial([np.random.default_rng(k) for k in range(2)])
    weights = torch.from_numpy(start + 0.05 * np.random.default_rng(7).standard_normal(start.shape))
    return model, weights, {key: torch.from_numpy(array) for key, array in model.prepare(*SAMPLES).items()}


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("hamiltonian", "acceleration"),
        ("hamiltonian", "port_error"),
        ("symoden", "acceleration"),
        ("sparse", "implicit_error"),
    ],
)
def test_gradients_are_those_of_finite_differences(name, quantity):
    model, weights, prepared = _made(name)
    direction = torch.from_numpy(np.random.default_rng(3).standard_normal(weights.shape))

    def values(step):
        return getattr(model.evaluate(weights + step * direction, prepared, mass=True), quantity)

    rows, jacobian = model.rows(weights, prepared, lambda terms: getattr(terms, quantity), True)
    assert_close(rows, values(0.0))
    numeric = (values(1e-6) - values(-1e-6)) / 2e-6
    along = torch.einsum("mrni,mi->mnr", jacobian, direction)
    assert_close(along, numeric, rtol=1e-5, atol=1e-5 * float(numeric.abs().max()))


def test_the_energy_of_symoden_gains_what_its_input_does_and_loses_what_its_friction_takes():
    model, weights, prepared = _made("symoden")
    acceleration = model.evaluate(weights, prepared).acceleration
    step = 1e-5

    def energy(s):
        moved = prepared | {
            "q": prepared["q"] + s * prepared["qd"] + s**2 / 2 * acceleration,
            "qd": prepared["qd"] + s * acceleration,
        }
        return model.evaluate(weights, moved).energy_sum

    outputs = model.outputs(weights, prepared, mass=False)
    push = outputs[2][:, :, 0].unflatten(-1, (3, 3)) @ prepared["tau"].unsqueeze(-1)
    braking = model._lower(outputs[3])[:, :, 0].mT @ prepared["qd"].unsqueeze(-1)
    power = (push.squeeze(-1) * prepared["qd"]).sum(-1) - braking.square().sum((-1, -2))
    assert_close((energy(step) - energy(-step)) / (2 * step), power, rtol=1e-5, atol=1e-4)


def test_a_hamiltonian_keeps_its_energy_in_free_motion_and_accelerates_as_its_velocities_say():
    model = Hamiltonian(DIP, POSITIONS, np.ones(3), hamiltonian.Options(hidden=(6, 5)))
    weights = model.initial([np.random.default_rng(0)])
    start = np.concatenate([DATA.q[0, :4], DATA.qd[0, :4]], axis=1)
    (motion,) = model_motion(model, weights, start[None], np.zeros((1, 4, 40, 3)), 0.01, DIP.angles)
    assert np.array_equal(motion[:, 0], start)
    parameters, state = torch.from_numpy(weights), model.state(start)[None]
    energies = []
    for _ in range(2):
        jets = {"jets": torch.from_numpy(model._jets(*np.split(state, 2, axis=-1)))}
        zero = torch.zeros(1, 4, 3, dtype=torch.float64)
        terms = model.evaluate(parameters, jets | {"qd": zero, "tau": zero, "rate": zero}, mass=True)
        energies.append(terms.energy)
        rate = model.state_rate(parameters, state, np.zeros((1, 4, 3)))
        ahead, behind = (model.motion_of(parameters, state + h * rate)[..., 3:] for h in (1e-5, -1e-5))
        np.testing.assert_allclose((ahead - behind) / 2e-5, terms.acceleration, rtol=1e-5, atol=1e-6)
        for _ in range(50):
            middle = state + 0.005 * model.state_rate(parameters, state, np.zeros((1, 4, 3)))
            state = state + 0.01 * model.state_rate(parameters, middle, np.zeros((1, 4, 3)))
    np.testing.assert_allclose(*energies, rtol=1e-4)


def test_the_ratio_of_sparse_sums_finds_the_cart_pole_exactly_and_the_sum_alone_does_not():
    sip = load("sip")
    data = random_force(sip, seeds=(0,), samples=600, reset="random", episode_steps=50, train_fraction=0.5)
    errors = {}
    for form in ("implicit", "explicit"):
        model = Sparse(2, position_features(sip.coordinates), sparse.Options(form=form))
        task = make_task(model, data.train, Objective(implicit.Options()))
        problem = TrainingProblem(model, [task], (0,))
        start = torch.from_numpy(model.initial([np.random.default_rng(0)]))
        found = Selection(threshold=1e-3).fit(problem, start, silent, NoCheckpoint())
        test = data.test
        predicted = predict(model, found.parameters, test.q, test.qd, test.qdd, test.tau).acceleration
        errors[form] = np.abs(predicted - test.qdd).mean()
    assert errors["implicit"] < 1e-9
    assert errors["explicit"] > 1e-3
