"""Learning without accelerations: the path fit against the usual way, shooting through a neural ODE with Adam.

As in SymODEN (Zhong, Dey and Chakraborty 2020): Runge-Kutta roll-outs from recorded states, the squared distance to
what was recorded later, and its gradient by automatic differentiation. The network is the same, and its own derivatives
with respect to q are analytic here, which is quicker than differentiating T and V.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch
from torch import Tensor

from repro.bench.accuracy import METRICS
from repro.bench.pairing import PairedComparison, Pairs
from repro.bench.scale import BenchScale
from repro.bench.training_case import PENDULUM
from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset
from repro.data.random_force import random_force
from repro.learning.objective import Objective
from repro.learning.objectives import balance
from repro.learning.objectives.balance import balance_task
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.path.path_fit import PathOptions, fit_path
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.system import load
from repro.models.kinds.structured import Structured

HORIZON = 5  # steps of a roll-out
BATCH = 512  # roll-outs
RATE = 1e-2  # of Adam, which falls to 0 along half a cosine
TRIED = 20  # steps, by which the number of steps within some seconds is found
ERROR_SCALE = 20.0  # m/s^2 and rad/s^2, of the weights of the balance
RECORDED = RandomForce(
    reset="random", measured="states", q_noise=1e-3, qd_noise=1e-2, labels="smoothed", episode_steps=50
)


@dataclass(frozen=True)
class NeuralODE:
    """A network for a cart with links on recorded states, for one member of a dataset."""

    model: Structured
    data: Dataset

    def acceleration(self, weights: Tensor, q: Tensor, qd: Tensor, tau: Tensor) -> Tensor:
        """qdd (sample, n_q) of q, qd, tau (sample, n_q); weights (1, n_parameters)."""
        model, scale = self.model, torch.from_numpy(self.model.velocity_scale)
        cosine, sine = torch.cos(q[:, 1:]), torch.sin(q[:, 1:])
        slopes = torch.cat([torch.diag_embed(-sine), torch.diag_embed(cosine)], dim=2)
        jets = torch.cat([torch.cat([cosine, sine], dim=1)[:, None], slopes], dim=1)
        entries = model.network.propagate(weights[:, model.network_slice], jets[None])[0]
        factors = entries.unflatten(-1, (model.n_q, model.rank))
        factor, by_angle, velocity = factors[:, 0], factors[:, 1:], qd / scale
        rate = (by_angle * qd[:, 1:, None, None]).sum(1)
        u = torch.einsum("sir,si->sr", factor, velocity)
        inertial = torch.einsum("sir,sr->si", rate, u) + torch.einsum("sir,sjr,sj->si", factor, rate, velocity)
        push = torch.einsum("skir,si,sr->sk", by_angle, velocity, u)
        slope = -weights[0, model.potential_slice] * sine  # of V
        rest = inertial / scale + torch.nn.functional.pad(slope - push, (1, 0))
        mass = factor @ factor.mT / (scale[:, None] * scale)
        solved: Tensor = torch.linalg.solve(mass, tau - rest)
        return solved

    def error(self, weights: np.ndarray) -> float:
        """MAE of qdd on the clean test part."""
        test = self.data.test
        q, qd, qdd, tau = (torch.from_numpy(each[0]) for each in (test.q, test.qd, test.qdd, test.tau))
        with torch.no_grad():
            return float((self.acceleration(torch.from_numpy(weights)[None], q, qd, tau) - qdd).abs().mean())

    def fitted(self, start: np.ndarray, steps: int, seed: int) -> np.ndarray:
        """Weights (n_parameters,) after so many steps of Adam."""
        train = self.data.train
        assert train.measurement is not None
        record = train.measurement.arrays()
        states, noise = (
            torch.from_numpy(np.concatenate([record[f"measured.{name}{ending}"] for name in ("q", "qd")], axis=-1))
            for ending in ("", "_noise")
        )
        states, tau = states[0], torch.from_numpy(train.tau[0])
        within = train.episode[HORIZON:] == train.episode[:-HORIZON]
        firsts, draw = np.flatnonzero(within), np.random.default_rng([seed, 31])
        weights = torch.tensor(start)[None].requires_grad_()
        optimiser = torch.optim.Adam([weights], lr=RATE)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
        for _ in range(steps):
            first = torch.from_numpy(draw.choice(firsts, BATCH))
            state, loss = states[first], torch.zeros((), dtype=torch.float64)
            for step in range(HORIZON):
                state = self._advanced(weights, state, tau[first + step])
                loss = loss + ((state - states[first + step + 1]) / noise).square().mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            schedule.step()
        return weights.detach()[0].numpy().copy()

    def _advanced(self, weights: Tensor, state: Tensor, tau: Tensor) -> Tensor:
        n = self.model.n_q

        def rate(x: Tensor) -> Tensor:
            return torch.cat([x[:, n:], self.acceleration(weights, x[:, :n], x[:, n:], tau)], dim=1)

        advanced: Tensor = rk4_step(rate, state, self.data.time_step)
        return advanced


def by_path(rival: NeuralODE, start: np.ndarray, seed: int) -> np.ndarray:
    """Weights (n_parameters,) of the path fit, from the momentum balance that starts at the same weights."""
    model, train = rival.model, rival.data.train
    task = balance_task(model, train, Objective(balance.Options()), 0.2, ERROR_SCALE)
    optimiser = LevenbergMarquardt(iterations=40, restarts=1)
    problem = TrainingProblem(model, [task], [seed])
    balanced = optimiser.fit(problem, start[None], silent, NoCheckpoint())
    return fit_path(model, train, 0, np.asarray(balanced.parameters[0]), PathOptions(), silent).parameters


def race(seeds: range, samples: int, patience: float, clock: Callable[[], float] = time.process_time) -> Pairs:
    """Seconds of both until the error of the path fit is reached, one pair per seed.

    Adam has as many seconds as the path fit, then twice as many, and so on up to `patience` times.
    """
    ours, other = [], []
    for seed in seeds:
        whole = samples + samples // 2
        source = replace(RECORDED, samples=whole, train_fraction=samples / whole)
        data = random_force(load(PENDULUM), [seed], source)
        rival = NeuralODE(Structured(data.n_q, data.train.qd[0].std(0)), data)
        start = rival.model.initial([np.random.default_rng([seed, 1])])[0]
        by_path(rival, start, seed)  # a warm-up: code is generated here
        begun = clock()
        goal = rival.error(by_path(rival, start, seed))
        ours.append(clock() - begun)
        rival.fitted(start, 1, seed)
        begun = clock()
        rival.fitted(start, TRIED, seed)
        per_second = TRIED / (clock() - begun)
        share, found = 1.0, math.inf
        while share <= patience and math.isinf(found):
            begun = clock()
            reached = rival.error(rival.fitted(start, max(1, round(share * ours[-1] * per_second)), seed))
            found = clock() - begun if reached <= goal else math.inf
            share *= 2
        other.append(found)
    return Pairs(np.array(ours), np.array(other))


def paths(scale: BenchScale) -> Iterator[PairedComparison]:
    """The path fit against shooting, on recorded states of the single pendulum."""
    size, samples = scale.race, min(scale.race.samples, 2000)
    protocol = (
        f"processor time until the error of qdd that the path fit reaches; one thread, {samples} noisy states at 25 "
        f"Hz; roll-outs of {HORIZON} steps, {BATCH} at a time, from recorded states; {{pairs}} starts, one per pair; "
        f"Adam has 1, 2, 4, ... times the seconds of ours; infinite: not reached in {size.patience:g} times"
    )
    measure = partial(race, range(size.starts), samples, size.patience)
    yield PairedComparison("path", "path fit", "neural ODE, Adam", "8", 1, protocol, measure, METRICS[0])
