"""Learning without accelerations: the path fit against the usual way, shooting through a neural ODE with Adam.

As in SymODEN (Zhong, Dey and Chakraborty 2020): Runge-Kutta roll-outs from recorded states, the squared distance to
what was recorded later, and its gradient by automatic differentiation. The network is the same, and its own derivatives
with respect to q are analytic here, which is quicker than differentiating T and V.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from torch import Tensor

from repro.bench.accuracy import ENDLESS, METRICS
from repro.bench.pairing import PairedComparison, Pairs
from repro.bench.scale import BenchScale
from repro.bench.training_case import PENDULUM, wide
from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset
from repro.data.random_force import random_force
from repro.evaluation.predictions import predict
from repro.learning.objective import Objective
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.objectives import path, prediction
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.optimisers.adam import Adam
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import Fitted, NoCheckpoint, silent
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.kinds.structured import Options, Structured
from repro.models.model import Model
from repro.models.position import cart_with_links

WIDTH = 8  # of every hidden layer
HORIZON = 1  # steps of a roll-out: with more of them the errors after equal times are larger
BATCH = 512  # roll-outs
ERROR_SCALE = 20.0  # m/s^2 and rad/s^2, of the weights of the balance
RECORDED = RandomForce(
    reset="random", measured="states", q_noise=1e-3, qd_noise=1e-2, labels="smoothed", episode_steps=50
)


class NeuralODE(Structured):
    """A structured model of a cart with links whose accelerations can be differentiated."""

    def acceleration_at(self, parameters: Tensor, q: Tensor, qd: Tensor, tau: Tensor) -> Tensor:
        """qdd (member, sample, n_q), differentiable in all arguments."""
        scale, value_and_angles = torch.from_numpy(self.velocity_scale), [0, *range(2, self.n_q + 1)]
        jets = cart_with_links(self.n_q).slopes(q)[:, :, value_and_angles]
        entries = self.network.propagate(parameters[:, self.network_slice], jets)
        factors = entries.unflatten(-1, (self.n_q, self.rank))
        factor, by_angle, velocity = factors[:, :, 0], factors[:, :, 1:], qd / scale
        rate = (by_angle * qd[:, :, 1:, None, None]).sum(2)
        u = torch.einsum("msir,msi->msr", factor, velocity)
        inertial = torch.einsum("msir,msr->msi", rate, u) + torch.einsum("msir,msjr,msj->msi", factor, rate, velocity)
        push = torch.einsum("mskir,msi,msr->msk", by_angle, velocity, u)
        slope = -parameters[:, None, self.potential_slice] * torch.sin(q[:, :, 1:])  # of V
        rest = inertial / scale + torch.nn.functional.pad(slope - push, (1, 0))
        mass = factor @ factor.mT / (scale[:, None] * scale)
        solved: Tensor = torch.linalg.solve(mass, tau - rest)
        return solved


def by_path(data: Dataset, seed: int) -> float:
    """MAE of qdd after the path fit of a structured model, which starts from the momentum balance."""
    model, options = wide((WIDTH,))(data), path.Options(error_scale=ERROR_SCALE)
    balanced = _fitted(model, options, LevenbergMarquardt(iterations=40, restarts=1), data, seed)
    return _error(model, options.finished(model, data.train, balanced, _initial(model, seed), silent), data)


def by_shooting(data: Dataset, seed: int, seconds: float) -> float:
    """MAE of qdd after so many CPU seconds of Adam, whose rate falls along half a cosine over them."""
    model = NeuralODE(data.n_q, data.train.qd[0].std(0), Options(hidden=(WIDTH,)))
    adam = Adam(epochs=ENDLESS, schedule="cosine", batch_size=BATCH, budget_s=seconds)
    return _error(model, _fitted(model, prediction.Options(intervals=HORIZON), adam, data, seed), data)


def _fitted(model: Model, options: ObjectiveOptions, optimiser: OptimiserOptions, data: Dataset, seed: int) -> Fitted:
    problem = TrainingProblem(model, [options.task(model, data.train, Objective(options))], [seed])
    return optimiser.fit(problem, _initial(model, seed), silent, NoCheckpoint())


def _initial(model: Model, seed: int) -> np.ndarray:
    return model.initial([np.random.default_rng([seed, 1])])


def _error(model: Model, fitted: Fitted, data: Dataset) -> float:
    """MAE of qdd on the clean test part."""
    test = data.test
    predicted = predict(model, np.asarray(fitted.parameters), test.q, test.qd, test.qdd, test.tau).acceleration
    return float(np.abs(predicted - test.qdd).mean())


def race(seeds: range, samples: int, patience: float, clock: Callable[[], float] = time.process_time) -> Pairs:
    """Seconds to the error of the path fit, a pair per seed; Adam has 1, 2, 4, ... `patience` times those of ours."""
    ours, other = [], []
    for seed in seeds:
        whole = samples + samples // 2
        source = replace(RECORDED, samples=whole, train_fraction=samples / whole)
        data = random_force(load(PENDULUM), [seed], source)
        by_path(data, seed)  # a warm-up: code is generated here
        begun = clock()
        goal = by_path(data, seed)
        ours.append(clock() - begun)
        share, found = 1.0, math.inf
        while share <= patience and math.isinf(found):
            begun = clock()
            reached = by_shooting(data, seed, share * ours[-1])
            found = clock() - begun if reached <= goal else math.inf
            share *= 2
        other.append(found)
    return Pairs(np.array(ours), np.array(other))


def paths(scale: BenchScale) -> Iterator[PairedComparison]:
    """The path fit against shooting, on recorded states of the single pendulum."""
    size, samples = scale.race, min(scale.race.samples, 2000)
    protocol = (
        f"processor time until the error of qdd that the path fit reaches; one thread, {samples} noisy states at 25 "
        f"Hz; roll-outs of one step, {BATCH} at a time, from recorded states; {{pairs}} starts, one "
        f"per pair; Adam has 1, 2, 4, ... times the seconds of ours; infinite: not reached in {size.patience:g} times"
    )
    measure = partial(race, range(size.starts), samples, size.patience)
    yield PairedComparison("path", "path fit", "neural ODE, Adam", f"{WIDTH}", 1, protocol, measure, METRICS[0])
