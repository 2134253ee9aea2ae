"""Models of every kind, at random weights, with random data."""

import numpy as np
import pytest
import torch

from repro.models.bases import engineered, library, raw, t1, t2
from repro.models.damped import Damped
from repro.models.kinds import blackbox, neural_potential, port_hamiltonian, structured
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.neural_potential import NeuralPotential
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian
from repro.models.position import PositionFeatures

N_Q = 2
LAGRANGIANS = {
    "t1": lambda: Lagrangian(t1, N_Q),
    "library": lambda: Lagrangian(library, N_Q),
    "t2": lambda: Lagrangian(t2, N_Q, hidden=(7,)),
    "t2 deep": lambda: Lagrangian(t2, N_Q, hidden=(6, 5), activation="tanh"),
    "t2 with momentum transform": lambda: Lagrangian(t2, N_Q, hidden=(4,), momentum_hidden=(3,)),
    "raw": lambda: Lagrangian(raw, N_Q, hidden=(5,)),
    "engineered": lambda: Lagrangian(engineered, N_Q, hidden=(5,)),
    "structured": lambda: Structured(N_Q, np.array([0.9, 5.0]), structured.Options(hidden=(6,))),
    "t1 beside friction": lambda: Damped(Lagrangian(t1, N_Q), "full"),
    "structured beside joint friction": lambda: Damped(
        Structured(N_Q, np.array([0.9, 5.0]), structured.Options(hidden=(3,))), "diagonal"
    ),
    "port-Hamiltonian": lambda: _port("canonical", "state"),
    "port-Hamiltonian of constant damping": lambda: _port("canonical", "constant"),
    "port-Hamiltonian without damping": lambda: _port("canonical", "none"),
    "port-Hamiltonian of a basis": lambda: PortHamiltonian(
        Lagrangian(t1, N_Q), np.array([0.9, 5.0]), port_hamiltonian.Options(damping_hidden=(3,), floor=0.0)
    ),
    "structured with a triangular factor": lambda: Structured(
        N_Q,
        np.array([0.9, 5.0]),
        structured.Options(hidden=(6,), factor="triangular", initialisation="glorot", activation="softplus"),
    ),
    "neural potential": lambda: NeuralPotential(
        np.array([0.9, 5.0]), np.ones(N_Q), [1], neural_potential.Options(hidden=(3,))
    ),
    "neural potential beside friction": lambda: Damped(
        NeuralPotential(np.array([0.9, 5.0]), np.ones(N_Q), [], neural_potential.Options(potential_hidden=(3,))),
        "diagonal",
    ),
    "structured with a network for V": lambda: Structured(
        N_Q,
        np.array([0.9, 5.0]),
        structured.Options(hidden=(4,), potential="network", potential_hidden=(3,)),
        positions=PositionFeatures((1,), ((0, 0.7),)),
    ),
    "structured deep": lambda: Structured(N_Q, np.array([0.9, 5.0]), structured.Options(hidden=(4, 4), skip=False)),
}
FREE = {
    "structured beside a gyroscopic matrix": lambda: Damped(
        Structured(N_Q, np.array([0.9, 5.0]), structured.Options()), "gyroscopic"
    ),
    "port-Hamiltonian of free J": lambda: _port("free", "state"),
    "port-Hamiltonian of free J and R": lambda: _port("full", "state"),
    "port-Hamiltonian with a momentum of its own": lambda: PortHamiltonian(
        Lagrangian(t2, N_Q, hidden=(3,)),
        np.array([0.9, 5.0]),
        port_hamiltonian.Options(damping_hidden=(2,), momentum_hidden=(3,), floor=0.0),
    ),
}
MODELS = LAGRANGIANS | FREE | {"blackbox": lambda: BlackBox(N_Q, blackbox.Options(hidden=(6, 5)))}


@pytest.fixture(params=LAGRANGIANS)
def lagrangian_model(request):
    return LAGRANGIANS[request.param]()


@pytest.fixture(params=MODELS)
def any_model(request):
    return MODELS[request.param]()


@pytest.fixture
def samples():
    generator = np.random.default_rng(1)
    names = ("q", "qd", "qdd", "tau")
    return {name: scale * generator.normal(size=(3, 11, N_Q)) for name, scale in zip(names, (2, 2, 5, 3), strict=True)}


@pytest.fixture
def start():
    return _start


@pytest.fixture
def prepare():
    return lambda model, samples: {name: torch.from_numpy(array) for name, array in model.prepare(**samples).items()}


def _port(structure, dissipation):
    scale = np.array([0.9, 5.0])
    energy = Structured(N_Q, scale, structured.Options(hidden=(3,)))
    return PortHamiltonian(
        energy,
        scale,
        port_hamiltonian.Options(structure=structure, dissipation=dissipation, damping_hidden=(3,), floor=1e-3),
    )


def _start(model, members=3, seed=0):
    generators = [np.random.default_rng([seed, member]) for member in range(members)]
    parameters = model.initial(generators)
    return torch.from_numpy(parameters + 0.1 * np.random.default_rng(seed).normal(size=parameters.shape))
