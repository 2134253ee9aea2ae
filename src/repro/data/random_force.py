"""D: the system driven by a random force, as in section V-A."""

from collections.abc import Sequence

import numpy as np

from repro.data.checks import check_choice, check_not_negative, check_positive, check_seeds, training_size
from repro.data.data_options import Regime
from repro.data.dataset import Dataset
from repro.data.sensors import Sensors
from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import generalised_force, input_limits, under_inputs
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System

STREAMS = ("force", "reset", "tau", "qdd", "q", "qd", "recorded_force")
MEASURED = ("accelerations", "states", "positions")
LABELS = ("exact", "differenced", "savitzky_golay", "smoothed")


def random_force(
    system: System,
    *,
    seeds: Sequence[int],
    samples: int = 100_000,
    train_fraction: float = 0.8,
    train_samples: int | None = None,
    time_step: float = 0.04,
    force_limit: float | None = None,
    regime: str = Regime.EPISODES,
    episode_steps: int = 1000,
    start: str | None = None,
    reset: str = "start",
    labels: str = "exact",
    tau_noise: float = 0.0,
    qdd_noise: float = 0.0,
    q_noise: float = 0.0,
    qd_noise: float = 0.0,
    force_noise: float = 0.0,
    measured: str = "accelerations",
    sample_step: float | None = None,
    quantisation: Sequence[float] = (),
    encoder_zero: float = 0.0,
    wrapped: bool = False,
    common: bool = False,
) -> Dataset:
    """Simulate one member per seed under inputs U(-force_limit, force_limit) held over each step of time_step s.

    force_limit: of every input in its unit; None takes the system's limit of each.

    regime: `long` is one trajectory, `episodes` starts anew every episode_steps; start: name of a state of rest of the
    system, its first one by default; reset: each episode from the `start`, or at `random` within its `reset_ranges`;
    sample_step: s between two samples, a whole part of time_step, which it is by default. `samples` and `episode_steps`
    count samples. What is recorded (see `Sensors` for measured, noise, quantisation, encoder_zero and wrapped) touches
    the training part alone, so that a test error is an error of the model. labels: what is not recorded is `exact`,
    `differenced`, of local polynomials (`savitzky_golay`) or `smoothed`. force_noise: of the recorded inputs.
    train_samples: only the first so many of the training part are kept, so that fits from more or from less data meet
    the same test part. common: every member has the data of the first seed. UserError names the argument that is out of
    range.
    """
    check_seeds(seeds)
    limits = input_limits(system) if force_limit is None else np.full(len(system.inputs), float(force_limit))
    check_positive(samples=samples, time_step=time_step, force_limit=limits.min(), episode_steps=episode_steps)
    noise = {"tau": tau_noise, "qdd": qdd_noise, "q": q_noise, "qd": qd_noise, "force": force_noise}
    check_not_negative(**{f"{name}_noise": deviation for name, deviation in noise.items()})
    check_choice("regime", regime, tuple(Regime))
    check_choice("reset", reset, ("start", "random"))
    check_choice("labels", labels, LABELS)
    check_choice("measured", measured, MEASURED)
    if measured != "accelerations" and labels == "exact":
        raise UserError(f"labels = 'exact': measured = {measured!r} records no accelerations; choose another of labels")
    if len(quantisation) not in (0, 2):
        raise UserError(f"quantisation = {list(quantisation)}: two steps, of lengths (m) and of angles (rad), or []")
    step, held = _held_samples(time_step, sample_step)
    n_train = training_size(samples, train_fraction)
    length = Regime(regime).length(samples, episode_steps)
    # one random stream per purpose, so that enabling one noise does not change the other draws
    streams = [
        {name: np.random.default_rng([seed, index]) for index, name in enumerate(STREAMS)}
        for seed in (seeds[:1] if common else seeds)
    ]
    episodes = -(-samples // length)
    shape = episodes * -(-length // held), len(limits)
    inputs = np.stack([s["force"].uniform(-limits, limits, shape) for s in streams])
    inputs = np.repeat(inputs.reshape(len(streams), episodes, -1, len(limits)), held, axis=2)[:, :, :length]
    inputs = inputs.reshape(len(streams), -1, len(limits))[:, :samples]
    starts = np.stack([_starts(system, episodes, start, reset, s["reset"]) for s in streams])
    states, tau = _trajectories(system, starts, inputs, length, step)
    exact = Dataset.from_motion(
        system,
        states,
        tau,
        time_step=step,
        episode_steps=length,
        n_train=n_train,
        provenance={
            "source": "random_force",
            "seeds": [int(seed) for seed in seeds],
            "force_limit": force_limit,
            "regime": regime,
            "episode_steps": length,
            "start": start,
            "reset": reset,
            "measured": measured,
            "labels": labels,
            "noise": noise,
            "common": common,
        },
    )
    sensors = Sensors(measured, labels, noise, tuple(quantisation), encoder_zero, wrapped)
    kept = sensors.record(exact, streams, system)
    if train_samples is not None and train_samples < n_train:
        check_positive(train_samples=train_samples)
        kept = kept.select(np.r_[:train_samples, n_train:samples], train_samples)
    return kept.of_members([0] * len(seeds)) if common else kept


def _held_samples(time_step: float, sample_step: float | None) -> tuple[float, int]:
    """Seconds between samples, and how many samples a force is held for."""
    if sample_step is None:
        return time_step, 1
    check_positive(sample_step=sample_step)
    held = round(time_step / sample_step)
    if held < 1 or abs(held * sample_step - time_step) > 1e-9:
        raise UserError(f"sample_step = {sample_step}: time_step = {time_step} s must be a whole multiple of it")
    return sample_step, held


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
