"""D: the system driven by a random force, as in section V-A."""

from collections.abc import Sequence

import numpy as np

from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset, check_seeds, training_size
from repro.data.sensors import recorded
from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import generalised_force, input_limits, under_inputs
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System

STREAMS = ("force", "reset", "tau", "qdd", "q", "qd", "recorded_force")
DESCRIBED = ("source", "force_limit", "regime", "start", "reset", "measured", "labels", "noise", "common")


def random_force(system: System, seeds: Sequence[int], source: RandomForce) -> Dataset:
    """Simulate one member per seed under random inputs; UserError for options that do not fit each other.

    What is recorded touches the training part alone, so that a test error is an error of the model.
    """
    check_seeds(seeds)
    samples, force_limit = source.samples, source.force_limit
    limits = input_limits(system) if force_limit is None else np.full(len(system.inputs), float(force_limit))
    if (problem := next(source.problems(), None)) is not None:
        raise UserError(problem)
    step, held = source.sample_step or source.time_step, source.held_samples
    n_train = training_size(samples, source.train_fraction)
    length = samples if source.regime == "long" else min(source.episode_steps, samples)
    # one random stream per purpose, so that enabling one noise does not change the other draws
    streams = [
        {name: np.random.default_rng([seed, index]) for index, name in enumerate(STREAMS)}
        for seed in (seeds[:1] if source.common else seeds)
    ]
    episodes = -(-samples // length)
    shape = episodes * -(-length // held), len(limits)
    inputs = np.stack([s["force"].uniform(-limits, limits, shape) for s in streams])
    inputs = np.repeat(inputs.reshape(len(streams), episodes, -1, len(limits)), held, axis=2)[:, :, :length]
    inputs = inputs.reshape(len(streams), -1, len(limits))[:, :samples]
    starts = np.stack([_starts(system, episodes, source.start, source.reset, s["reset"]) for s in streams])
    states, tau = _trajectories(system, starts, inputs, length, step)
    described = {name: getattr(source, name) for name in DESCRIBED}
    exact = Dataset.from_motion(
        system,
        states,
        tau,
        time_step=step,
        episode_steps=length,
        n_train=n_train,
        provenance={"seeds": [int(seed) for seed in seeds], **described, "episode_steps": length},
    )
    kept = recorded(source, exact, streams, system)
    if source.train_samples is not None and source.train_samples < n_train:
        kept = kept.select(np.r_[: source.train_samples, n_train:samples], source.train_samples)
    return kept.of_members([0] * len(seeds)) if source.common else kept


def _starts(system: System, episodes: int, start: str | None, reset: str, stream: np.random.Generator) -> np.ndarray:
    """Return initial states (episode, 2 n_q)."""
    q = np.tile(system.at_rest(start), (episodes, 1))
    if reset == "start":
        return np.concatenate([q, np.zeros_like(q)], axis=1)
    low, high = np.array(system.reset_ranges).transpose(2, 1, 0)
    q = stream.uniform(low[0], high[0], q.shape)
    qd = (low[1] + high[1]) / 2 + stream.uniform(-1.0, 1.0, q.shape) * (high[1] - low[1]) / 2
    return np.concatenate([q, qd], axis=1)


def _trajectories(
    system: System, starts: np.ndarray, inputs: np.ndarray, length: int, time_step: float
) -> tuple[np.ndarray, np.ndarray]:
    """States (member, sample, 2 n_q) and tau; starts: (member, episode, 2 n_q), inputs: (member, sample, n_u)."""
    members, samples, n_u = inputs.shape
    missing = starts.shape[1] * length - samples
    held = np.pad(inputs, ((0, 0), (0, missing), (0, 0))).reshape(-1, length, n_u)
    acceleration = under_inputs(dynamics_of(system).acceleration, system)
    states = simulate(acceleration, starts.reshape(len(held), -1), held, time_step, angles=system.angles)
    states = states[:, :-1].reshape(members, -1, 2 * system.n_q)[:, :samples]
    return states, generalised_force(system, states[..., : system.n_q], inputs)
