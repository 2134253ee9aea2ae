"""D_H: motion without force from rest, whose energy is therefore known."""

import itertools
from collections.abc import Sequence

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.data.checks import check_choice, check_positive, check_seeds, training_size
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System

FIRST_ANGLE = 0.03  # rad
LAST_ANGLE = 3.11  # rad
MOST_STARTS = 200_000


def free_motion(
    system: System,
    *,
    seeds: Sequence[int],
    initial_angles: int = 100,
    grid: str = "product",
    steps: int = 10,
    time_step: float = 0.04,
    train_fraction: float = 0.8,
) -> Dataset:
    """Simulate free motion from rest at each point of a grid over [0.03, 3.11] rad, for `steps` samples (V-B).

    grid: `product` has `initial_angles` angles a link in all combinations, `diagonal` has all links at the same angle.
    Every member has the same trajectories; its seed shuffles which whole ones are for training. The energy of all
    samples of a trajectory is that of its start, V there. UserError for a damped system or an argument out of range.
    """
    check_seeds(seeds)
    check_positive(initial_angles=initial_angles, steps=steps, time_step=time_step)
    check_choice("grid", grid, ("product", "diagonal"))
    if any(system.damping):
        raise UserError(f"damping = {list(system.damping)}: free motion keeps its energy only without damping")
    q_start = _grid(system, initial_angles, grid)
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
            "source": "free_motion",
            "seeds": [int(seed) for seed in seeds],
            "initial_angles": initial_angles,
            "grid": grid,
            "steps": steps,
        },
    )


def _grid(system: System, initial_angles: int, grid: str) -> np.ndarray:
    """Return coordinates (points, n_q): `initial_angles` ** number of angles, or `initial_angles` on the diagonal."""
    angles = np.linspace(FIRST_ANGLE, LAST_ANGLE, initial_angles)
    links = len(system.angles)
    if grid == "product" and initial_angles**links > MOST_STARTS:
        raise UserError(
            f"initial_angles = {initial_angles}: with {links} links these are {initial_angles**links} trajectories, "
            f"more than {MOST_STARTS}; take fewer, or grid = 'diagonal'"
        )
    q = np.zeros((initial_angles if grid == "diagonal" else initial_angles**links, system.n_q))
    q[:, system.angles] = angles[:, None] if grid == "diagonal" else list(itertools.product(angles, repeat=links))
    return q
