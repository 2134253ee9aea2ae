"""The energy of plant and model over long free motion: where a model without structure drifts away or diverges."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.evaluation.discrete_gradient import NotQuadraticError, integrate, phase_space
from repro.evaluation.model_motion import is_compiled, model_motion
from repro.evaluation.pointwise import MetricValues
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System
from repro.models.model import Model

STARTS = 20
TIME_STEP = 0.02  # s
SPEED, RATE = 1.0, 3.0  # m/s and rad/s of the starts, at most
SHOWN = 500  # points of a curve


@dataclass(frozen=True)
class FreeMotion:
    """The plant's energy along the plant's and the model's states, (member, start, time) in J; time in s."""

    time: np.ndarray
    plant: np.ndarray
    model: np.ndarray

    @property
    def gap(self) -> np.ndarray:
        """|H(model) - H(plant)|; infinite where the model has diverged."""
        return np.where(np.isfinite(self.model), np.abs(self.model - self.plant), np.inf)


def free_motion_energies(model: Model, parameters: np.ndarray, system: System, seconds: float) -> FreeMotion:
    """Motion without input from the same random starts: the plant by RK4, the model by its own structure if it has one.

    Models with a quadratic T are integrated by the discrete gradient, all others by RK4.
    """
    weights, steps = np.asarray(parameters, dtype=float), round(seconds / TIME_STEP)
    draw = np.random.default_rng(8).uniform(-1, 1, (2, STARTS, system.n_q))
    turns = np.array([coordinate.is_angle for coordinate in system.coordinates])
    # anywhere in angle, and moving
    starts = np.concatenate([draw[0] * np.where(turns, np.pi, 0.0), draw[1] * np.where(turns, RATE, SPEED)], axis=1)
    plant = simulate(
        dynamics_of(system).acceleration, starts, np.zeros((STARTS, steps, system.n_q)), TIME_STEP, angles=system.angles
    )
    predicted = _roll(model, weights, np.tile(starts, (len(weights), 1, 1)), steps, system)
    true = np.broadcast_to(_energy(system, plant), predicted.shape[:-1])
    return FreeMotion(np.arange(steps + 1) * TIME_STEP, true, _energy(system, predicted))


def energy_errors(motion: FreeMotion, horizons: Sequence[float]) -> Iterator[MetricValues]:
    """Mean over the starts of the largest energy error so far, a metric a horizon; and of all of them the worst."""
    largest = np.maximum.accumulate(motion.gap, axis=-1)
    for horizon in horizons:
        index = round(horizon / TIME_STEP)
        yield MetricValues("test", f"energy_error_{horizon:g}s", largest[..., index].mean(1), "J")
    yield MetricValues("test", "energy_error_worst", largest[..., -1].max(1), "J")


def energy_curves(motion: FreeMotion, seeds: Sequence[int]) -> Iterator[tuple[int, str, float, float]]:
    """Rows (member, name, t, value) of the first start's energies: free.plant.H and free.model.H."""
    shown = np.unique(np.linspace(0, len(motion.time) - 1, SHOWN).astype(int))
    for number, seed in enumerate(seeds):
        for name, energies in (("free.plant.H", motion.plant), ("free.model.H", motion.model)):
            for index in shown:
                yield seed, name, float(motion.time[index]), float(energies[number, 0, index])


def _roll(model: Model, weights: np.ndarray, starts: np.ndarray, steps: int, system: System) -> np.ndarray:
    if model.energetic and is_compiled(model):
        try:
            space = phase_space(model)
        except NotQuadraticError:
            pass
        else:
            each, start = np.repeat(weights, STARTS, axis=0), starts.reshape(-1, starts.shape[-1])
            states = integrate(space, evaluate(space.to_phase, start, each), steps, TIME_STEP, each)
            rates = np.stack([evaluate(space.to_rates, x, w) for x, w in zip(states, each, strict=True)])
            return rates.reshape(*starts.shape[:2], steps + 1, -1)
    tau = np.zeros((*starts.shape[:2], steps, system.n_q))
    return model_motion(model, weights, starts, tau, TIME_STEP, system.angles)


def _energy(system: System, states: np.ndarray) -> np.ndarray:
    q, qd = np.split(states, 2, axis=-1)
    return evaluate(dynamics_of(system).hamiltonian, q, qd)[..., 0]
