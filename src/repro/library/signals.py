"""What is kept of a test: the motions of plant and model over the first test points, and their energies."""

import numpy as np

from repro.evaluation.canonical import RestStates, in_gauge
from repro.evaluation.predictions import predict
from repro.evaluation.rollouts import ModelRollout
from repro.evaluation.uncertainty import motion_errors
from repro.library.ensemble_model import Ensemble
from repro.mechanics.derive import energies_along
from repro.mechanics.system import System
from repro.models.gauge import Gauge
from repro.models.model import Model

Signal = tuple[int, str, float, float]  # seed, name, s, value


def signals(ensemble: Ensemble, rollout: ModelRollout | None) -> list[Signal]:
    """Rows of every member: tau[i], episode, and the states and energies of plant and model by name.

    Standard errors of the model's states too, where the fit has an information. Energies are in the canonical gauge,
    where the true system is known.
    """
    if rollout is None:
        return []
    model, parameters, information = ensemble.model, ensemble.weights_, ensemble.information_
    test, system = ensemble.data.test, ensemble.system
    points = len(rollout.time)
    names = [c.name for c in test.coordinates] + [f"{c.name}d" for c in test.coordinates]
    episode = np.broadcast_to(test.episode[:points], (test.members, points))
    columns: dict[str, np.ndarray] = {f"tau[{index}]": test.tau[:, :points, index] for index in range(test.n_q)}
    columns["episode"] = episode
    for role, states in (("plant", rollout.plant), ("model", rollout.model), ("euler", rollout.one_step_euler)):
        columns |= {f"{role}.{name}": states[..., index] for index, name in enumerate(names)}
    if information is not None:
        errors = motion_errors(model, parameters, information, rollout.model, test)
        columns |= {f"standard_error.{name}": errors[..., index] for index, name in enumerate(names)}
    if system is not None and model.energetic:
        learned = learned_energies(model, parameters, system, rollout.model)
        for role, energies in (("plant", energies_along(system, rollout.plant)), ("model", learned)):
            columns |= {f"{role}.{name}": values for name, values in energies.items()}
    return [
        (seed, name, float(t), float(value))
        for name, values in columns.items()
        for seed, series in zip(ensemble.seeds, values, strict=True)
        for t, value in zip(rollout.time, series, strict=True)
    ]


def learned_energies(model: Model, parameters: np.ndarray, system: System, states: np.ndarray) -> dict[str, np.ndarray]:
    """T, V and T + V (member, point) in J along a motion (member, point, 2 n_q); not a number where it has diverged."""
    finite = np.isfinite(states).all(-1)
    states = np.where(finite[..., None], states, 0.0)
    q, qd = states[..., : system.n_q], states[..., system.n_q :]
    zero = np.zeros_like(q)
    predicted = predict(model, parameters, q, qd, zero, zero)
    terms = in_gauge(predicted, RestStates(model, parameters, system, q), qd, Gauge.CANONICAL_ANCHOR)
    kinetic, potential = (np.where(finite, values, np.nan) for values in (terms.kinetic, terms.potential))
    return {"T": kinetic, "V": potential, "H": kinetic + potential}
