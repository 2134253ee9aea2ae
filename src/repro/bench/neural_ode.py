"""Learning without accelerations: the path fit against the usual way, shooting through a neural ODE with Adam.

The rival is SymODEN (Zhong, Dey and Chakraborty 2020): Runge-Kutta roll-outs from recorded states, the squared distance
to what was recorded later, and its gradient by automatic differentiation.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from repro.bench.accuracy import ENDLESS, METRICS
from repro.bench.pairing import PairedComparison, Pairs
from repro.bench.scale import BenchScale
from repro.bench.training_case import PENDULUM
from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset
from repro.data.random_force import random_force
from repro.evaluation.predictions import predict
from repro.learning.objective import Objective
from repro.learning.objectives import balance, prediction
from repro.learning.objectives.balance import balance_task
from repro.learning.optimisers.adam import Adam
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.path.path_fit import PathOptions, fit_path
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.kinds.structured import Structured
from repro.models.kinds.symoden import SymODEN
from repro.models.model import Model
from repro.models.position import cart_with_links

WIDTH = 8  # of every hidden layer
HORIZON = 5  # steps of a roll-out
BATCH = 512  # roll-outs
ERROR_SCALE = 20.0  # m/s^2 and rad/s^2, of the weights of the balance
RECORDED = RandomForce(
    reset="random", measured="states", q_noise=1e-3, qd_noise=1e-2, labels="smoothed", episode_steps=50
)


def by_path(data: Dataset, seed: int) -> float:
    """MAE of qdd after the path fit of a structured model, which starts from the momentum balance."""
    model, train = Structured(data.n_q, data.train.qd[0].std(0), hidden=(WIDTH,)), data.train
    task = balance_task(model, train, Objective(balance.Options()), 0.2, ERROR_SCALE)
    optimiser = LevenbergMarquardt(iterations=40, restarts=1)
    start = model.initial([np.random.default_rng([seed, 1])])
    balanced = optimiser.fit(TrainingProblem(model, [task], [seed]), start, silent, NoCheckpoint())
    fitted = fit_path(model, train, 0, np.asarray(balanced.parameters[0]), PathOptions(), silent)
    return _error(model, fitted.parameters, data)


def by_shooting(data: Dataset, seed: int, seconds: float) -> float:
    """MAE of qdd of SymODEN after so many CPU seconds of Adam, whose rate falls along half a cosine over them."""
    model, options = SymODEN(data.n_q, cart_with_links(data.n_q), hidden=(WIDTH,)), prediction.Options(HORIZON)
    problem = TrainingProblem(model, [options.task(model, data.train, Objective(options))], [seed])
    adam = Adam(epochs=ENDLESS, schedule="cosine", batch_size=BATCH, budget_s=seconds)
    fitted = adam.fit(problem, model.initial([np.random.default_rng([seed, 1])]), silent, NoCheckpoint())
    return _error(model, np.asarray(fitted.parameters[0]), data)


def _error(model: Model, weights: np.ndarray, data: Dataset) -> float:
    """MAE of qdd on the clean test part."""
    test = data.test
    predicted = predict(model, weights[None], test.q, test.qd, test.qdd, test.tau).acceleration
    return float(np.abs(predicted - test.qdd).mean())


def race(seeds: range, samples: int, patience: float, clock: Callable[[], float] = time.process_time) -> Pairs:
    """Seconds of both until the error of the path fit is reached, one pair per seed.

    Adam has as many seconds as the path fit, then twice as many, and so on up to `patience` times.
    """
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
        f"Hz; SymODEN by roll-outs of {HORIZON} steps, {BATCH} at a time, from recorded states; {{pairs}} starts, one "
        f"per pair; Adam has 1, 2, 4, ... times the seconds of ours; infinite: not reached in {size.patience:g} times"
    )
    measure = partial(race, range(size.starts), samples, size.patience)
    yield PairedComparison("path", "path fit", "neural ODE, Adam", f"{WIDTH}", 1, protocol, measure, METRICS[0])
