"""D_H: motion without force from rest, whose energy is therefore known."""

import itertools
from collections.abc import Sequence

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.data.data_options import FreeMotionOptions
from repro.data.dataset import Dataset, check_seeds, training_size
from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System

FIRST_ANGLE = 0.03  # rad
LAST_ANGLE = 3.11  # rad
MOST_STARTS = 200_000


def free_motion(
    system: System, seeds: Sequence[int], source: FreeMotionOptions, train_fraction: float = 0.8
) -> Dataset:
    """Simulate free motion from rest at each point of a grid over [0.03, 3.11] rad (V-B).

    Translations lie within their `reset_ranges`. Every member has the same trajectories; its seed shuffles which whole
    ones are for training. The energy of all samples of a trajectory is that of its start, V there. UserError for a
    damped system, and for a grid that is too large or too small.
    """
    check_seeds(seeds)
    steps, time_step = source.steps, source.time_step
    if not system.frictionless:
        friction = f"damping = {list(system.damping)}, coulomb = {list(system.coulomb)}"
        raise UserError(f"{friction}: free motion keeps its energy only without friction")
    q_start = _grid(system, source.initial_angles, source.grid)
    n_train = training_size(len(q_start), train_fraction, "initial_angles") * steps
    dynamics = dynamics_of(system)
    at_rest = np.zeros_like(q_start)
    force = np.zeros((len(q_start), steps - 1, system.n_q))
    initial = np.concatenate([q_start, at_rest], axis=1)
    states = simulate(dynamics.acceleration, initial, force, time_step, angles=system.angles)
    energy = np.repeat(evaluate(dynamics.hamiltonian, q_start, at_rest), steps, axis=1)
    order = np.stack([np.random.default_rng(seed).permutation(len(q_start)) for seed in seeds])
    samples = len(q_start) * steps
    x = states[order].reshape(len(seeds), samples, 2 * system.n_q)
    return Dataset.from_motion(
        system,
        x,
        np.zeros((len(seeds), samples, system.n_q)),
        time_step=time_step,
        episode_steps=steps,
        n_train=n_train,
        energy=energy[order].reshape(len(seeds), samples),
        provenance={
            "source": source.source,
            "seeds": [int(seed) for seed in seeds],
            "initial_angles": source.initial_angles,
            "grid": source.grid,
            "steps": steps,
        },
    )


def _grid(system: System, initial_angles: int, grid: str) -> np.ndarray:
    """Return coordinates (points, n_q): all combinations of `initial_angles` values each, or those on the diagonal.

    Cyclic coordinates, and those that a random episode too starts from 0, stay there.
    """
    ranges = {
        i: (FIRST_ANGLE, LAST_ANGLE) if coordinate.is_angle else span
        for i, (coordinate, (span, _)) in enumerate(zip(system.coordinates, system.reset_ranges, strict=True))
        if not coordinate.cyclic and span[0] < span[1]
    }
    points = [np.linspace(*span, initial_angles) for span in ranges.values()]
    starts = initial_angles ** (len(points) if grid == "product" else 1)
    if starts > MOST_STARTS:
        raise UserError(
            f"initial_angles = {initial_angles}: over {len(points)} coordinates these are {starts} trajectories, more "
            f"than {MOST_STARTS}; take fewer, or grid = 'diagonal'"
        )
    q = np.zeros((starts, system.n_q))
    if points:
        q[:, [*ranges]] = list(zip(*points, strict=True) if grid == "diagonal" else itertools.product(*points))
    return q
