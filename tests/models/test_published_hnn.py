"""HNN by the published recipe against its published figures (Greydanus et al. 2019, README and notebooks).

Noisy (q, p) with the derivatives of the noiseless points, 25 of 50 trajectories for training; two hidden layers of 200
tanh units on raw (q, p), orthogonal weights, no bias at the output; 2,001 full-batch steps of Adam at 1e-3 with weight
decay 1e-4. The published "energy MSE" is that of q^2 + p^2, for the pendulum too, along 15 random test trajectories.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
import torch
from torch import Tensor

from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.system import load
from repro.models.kinds import hamiltonian
from repro.models.kinds.hamiltonian import Hamiltonian
from repro.models.network import Network
from repro.models.position import PositionFeatures

SECONDS, STEPS = 20.0, 1000


@dataclass(frozen=True)
class Task:
    """H = (q^2 or 2 (1 - cos q)) + p^2; rate of the sampling in 1/s; radii of the starts; README figures, +- 2 s.e."""

    pull: Callable[[np.ndarray], np.ndarray]
    rate: int
    radii: tuple[float, float]
    test_loss: tuple[float, float]
    energy: dict[str, tuple[float, float]]


TASKS = {
    "pendulum": Task(
        lambda q: 2 * np.sin(q), 15, (0.2, 2.0), (3.5586e-2, 1.8178e-3),
        {"hnn": (2.4852e-2, 5.42e-3), "mlp": (4.1519e-2, 9.62e-3)},
    ),
    "spring": Task(
        lambda q: 2 * q, 10, (0.1, 1.0), (3.5928e-2, 1.8328e-3),
        {"hnn": (3.8416e-4, 6.53e-5), "mlp": (1.7077e-1, 2.06e-2)},
    ),
}  # fmt: skip


def _flow(task: Task, x: np.ndarray) -> np.ndarray:
    return np.stack([2 * x[..., 1], -task.pull(x[..., 0])], axis=-1)


def _integrated(rate: Callable[[np.ndarray], np.ndarray], start: np.ndarray, seconds: float, steps: int) -> np.ndarray:
    states = [start]
    for _ in range(steps):
        states.append(rk4_step(rate, states[-1], seconds / steps))
    return np.stack(states, axis=1)


def _samples(task: Task, generator: np.random.Generator, trajectories: int) -> tuple[np.ndarray, np.ndarray]:
    start = generator.uniform(-1, 1, (trajectories, 2))
    radius = generator.uniform(*task.radii, (trajectories, 1))
    fine = 20
    count = 3 * task.rate
    path = _integrated(lambda x: _flow(task, x), start / np.linalg.norm(start, axis=1, keepdims=True) * radius,
                       3.0, (count - 1) * fine)[:, ::fine]  # fmt: skip
    noisy = path + 0.1 * generator.standard_normal(path.shape)
    return noisy.reshape(-1, 2), _flow(task, path).reshape(-1, 2)


class Published:
    """A model of [q, p] with its flow, as published: the HNN on this project's class, or the plain network."""

    def __init__(self, kind: str, generator: np.random.Generator) -> None:
        self.kind = kind
        if kind == "hnn":
            self.model = Hamiltonian(
                load("torque_pendulum"), PositionFeatures((), ((0, 1.0),)), np.ones(1), hamiltonian.Options()
            )
            self.network = self.model.network
        else:
            self.network = Network(2, (200, 200), 2, "tanh")
        arrays = []
        for shape in self.network.shapes:
            rows = np.zeros(shape)
            if len(shape) == 2:
                square = np.linalg.qr(generator.standard_normal((max(shape), min(shape))))[0]
                rows = square if shape[0] >= shape[1] else square.T
            arrays.append(rows.ravel())
        self.weights = torch.tensor(np.concatenate(arrays)[None], dtype=torch.float32, requires_grad=True)
        self.free = torch.ones_like(self.weights)
        self.free[:, -self.network.n_out :] = 0.0  # no bias at the output

    def rates(self, x: np.ndarray) -> Callable[[], Tensor]:
        """[dq/dt, dp/dt] (sample, 2) at x (sample, 2), to be evaluated at the present weights."""
        if self.kind == "mlp":
            rows = torch.tensor(x[None, :, None], dtype=torch.float32)
            return lambda: self.network.propagate(self.weights, rows)[0, :, 0]
        jets = torch.tensor(self.model._jets(x[None, :, :1], x[None, :, 1:]), dtype=torch.float32)
        zero = torch.zeros(1, len(x), 1)
        prepared = {"jets": jets, "qd": zero, "tau": zero, "rate": zero}
        return lambda: self.model.evaluate(self.weights, prepared).port_error[0]

    def fit(self, x: np.ndarray, rate: np.ndarray, steps: int = 2001) -> None:
        """Full-batch Adam."""
        predicted, target = self.rates(x), torch.tensor(rate, dtype=torch.float32)
        optimiser = torch.optim.Adam([self.weights], 1e-3, weight_decay=1e-4)
        for _ in range(steps):
            optimiser.zero_grad()
            (predicted() - target).square().mean().backward()
            assert self.weights.grad is not None
            self.weights.grad *= self.free
            optimiser.step()

    def flow(self, x: np.ndarray) -> np.ndarray:
        """The same as an array."""
        with torch.no_grad():
            return self.rates(x)().double().numpy()


def published_errors(name: str, kind: str, seed: int) -> tuple[float, float]:
    """Test loss and "energy MSE" of one fit."""
    task, generator = TASKS[name], np.random.default_rng(seed)
    x, rate = _samples(task, generator, 50)
    half = len(x) // 2
    model = Published(kind, generator)
    model.fit(x[:half], rate[:half])
    loss = float(((model.flow(x[half:]) - rate[half:]) ** 2).mean())
    start = generator.uniform(-0.8, 0.8, (15, 2))
    start += 0.2 * np.sign(start)
    true, own = (_integrated(f, start, SECONDS, STEPS) for f in (lambda s: _flow(task, s), model.flow))
    energy = ((true**2).sum(-1) - (own**2).sum(-1)) ** 2
    return loss, float(energy[:, :: STEPS // 100].mean())


@pytest.mark.slow
@pytest.mark.parametrize("name", TASKS)
def test_hnn_reaches_its_published_figures(name: str) -> None:
    loss, energy = np.array([published_errors(name, "hnn", seed) for seed in range(2)]).T
    for value, (printed, error) in ((loss, TASKS[name].test_loss), (energy, TASKS[name].energy["hnn"])):
        spread = np.hypot(error, value.std(ddof=1) / np.sqrt(len(value)))
        assert value.mean() < printed + 2 * spread
