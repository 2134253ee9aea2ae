"""Whether a fitted model is passive (Theorem 1), by its own energy and by the true one."""

from collections.abc import Iterator

import numpy as np

from repro.data.dataset import Dataset
from repro.evaluation.model_motion import is_compiled
from repro.evaluation.pointwise import MetricValues
from repro.mechanics.system import System
from repro.models.model import Model
from repro.models.passivity_margin import States, margins, worst_margin

STATES = 2000


def passivity(
    model: Model, parameters: np.ndarray, part: Dataset, system: System | None, split: str
) -> Iterator[MetricValues]:
    """The worst margin over random states by the model's own energy and by the plant's, and how often the latter fails.

    Nothing where the model's equations are singular, or neither compiled nor evaluated by the model itself.
    """
    if not is_compiled(model) and type(model).port_values is Model.port_values:
        return
    velocities = part.qd.reshape(-1, part.n_q).std(axis=0)
    states = States.random(part.coordinates, velocities, STATES, np.random.default_rng(9))
    weights = np.asarray(parameters, dtype=float)
    if model.energetic:
        yield MetricValues(split, "passivity_margin", worst_margin(model, weights, states), "1")
    if system is not None:
        by_plant = np.stack([margins(model, member, states, system) for member in weights])
        by_plant = np.where(np.isfinite(by_plant), by_plant, np.inf)
        yield MetricValues(split, "passivity_margin_plant", by_plant.max(1), "1")
        yield MetricValues(split, "gains_energy", (by_plant > 1e-9).mean(1), "1")
