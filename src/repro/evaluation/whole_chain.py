"""A chain learned as a whole, from samples of all of its links at once: what a composed chain is compared with."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import casadi
import numpy as np

from repro.data.dataset import Dataset
from repro.evaluation.chains import SECONDS, TIME_STEP, random_start, simulate_chain
from repro.evaluation.pointwise import MetricValues
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.system import System
from repro.models.ports import ChainLink


@dataclass(frozen=True)
class Samples:
    """Of a whole chain: extensions s, velocities v, accelerations and forces of all its masses, (sample, links)."""

    extension: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray


def whole_chain_errors(
    data: Dataset, seeds: Sequence[int], system: System, noise: float, links: Sequence[int]
) -> Iterator[MetricValues]:
    """For each number of links: relative error of the state after 10 s, and seconds of learning and simulating.

    The training samples are as many as those of the one link, with the same spread and the same noise (N) on every
    force; the true chain and the start are those of `chain_errors`.
    """
    truth = ChainLink.true(system)
    for number in links:
        start = random_start(number)
        final = simulate_chain(truth, start).states[-1]
        gaps, seconds = [], []
        for member, seed in enumerate(seeds):
            samples = draw(truth, data.train, member, number, noise, np.random.default_rng([seed, number, 6]))
            begun = time.process_time()
            state = follow(learn(samples), start, truth.mass)
            seconds.append(time.process_time() - begun)
            gaps.append(np.linalg.norm(state - final) / np.linalg.norm(final))
        yield MetricValues("test", f"whole_chain_error_{number}", np.nan_to_num(np.array(gaps), nan=np.inf), "1")
        yield MetricValues("test", f"whole_chain_seconds_{number}", np.array(seconds), "s")


def draw(
    truth: ChainLink, train: Dataset, member: int, links: int, noise: float, generator: np.random.Generator
) -> Samples:
    """As many samples of the true chain as one link has; each link's motion is drawn from those of that link."""
    rows = generator.integers(train.samples, size=(3, train.samples, links))
    one = (train.q[member, :, 0], train.qd[member, :, 0], train.qdd[member, :, 0])
    extension, velocity, acceleration = (values[index] for values, index in zip(one, rows, strict=True))
    s = casadi.SX.sym("s")
    spring = casadi.Function("force", [s], [casadi.gradient(truth.spring(s), s)])
    stretched = np.array(spring(extension.reshape(1, -1))).reshape(extension.shape)
    pull = stretched + truth.damping * _of_extensions(velocity)
    on_masses = -np.diff(pull, axis=-1, append=0.0)  # D' f: each is held by its own spring and pulled on by the next
    force = truth.mass * acceleration + on_masses
    return Samples(extension, velocity, acceleration, force + noise * generator.standard_normal(force.shape))


def learn(samples: Samples) -> np.ndarray:
    """Least squares for f = M vdot + K s + K_3 s^3 + C v, full matrices: [M | K | K_3 | C] as (4 links, links).

    The features are those of the link that is learned alone; which link pulls at which mass is not given.
    """
    features = np.concatenate([samples.acceleration, samples.extension, samples.extension**3, samples.velocity], axis=1)
    return np.asarray(np.linalg.lstsq(features, samples.force, rcond=None)[0])


def follow(coefficients: np.ndarray, start: np.ndarray, mass: float) -> np.ndarray:
    """The state [s; m v] (2 links,) after 10 s of free motion by RK4; not finite where the learned chain diverges."""
    links = coefficients.shape[1]
    inertia, rest = coefficients[:links].T, coefficients[links:].T
    motion = -np.linalg.solve(inertia, rest)

    def rate(x: np.ndarray) -> np.ndarray:
        extension, velocity = x[:links], x[links:]
        features = np.concatenate([extension, extension**3, velocity])
        return np.concatenate([_of_extensions(velocity), motion @ features])

    x = start / np.repeat([1.0, mass], links)
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(round(SECONDS / TIME_STEP)):
            x = rk4_step(rate, x, TIME_STEP)
    return np.asarray(x * np.repeat([1.0, mass], links))


def _of_extensions(velocity: np.ndarray) -> np.ndarray:
    """D v: the rate of each extension, (..., links)."""
    return np.diff(velocity, axis=-1, prepend=0.0)
