"""Errors of a linear basis: its coefficients, and which terms it kept."""

from collections.abc import Iterator

import numpy as np
from torch import Tensor

from repro.evaluation.metrics import Metric
from repro.mechanics.derive import dynamics_of, evaluate
from repro.mechanics.system import System
from repro.models.features import FeatureMap
from repro.models.lagrangian import Lagrangian

STATES = 500
SMALL = 1e-9


def true_coefficients(model: Lagrangian, system: System) -> np.ndarray | None:
    """Coefficients (n_parameters,) of the true T and V in the model's basis; None where they are not in its span."""
    generator = np.random.default_rng(0)
    q = generator.uniform(-np.pi, np.pi, (STATES, system.n_q))
    qd = generator.normal(size=q.shape)
    dynamics = dynamics_of(system)
    parts = []
    for features, energy in (
        (model.kinetic_features, dynamics.kinetic),
        (model.potential_features, dynamics.potential),
    ):
        columns, values = _values(features, q, qd), evaluate(energy, q, qd)[..., 0]
        solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
        if np.abs(columns @ solution - values).max() > SMALL:
            return None
        parts.append(np.where(np.abs(solution) < SMALL, 0.0, solution))
    return np.concatenate(parts)


def coefficient_errors(model: Lagrangian, parameters: Tensor, system: System, split: str) -> Iterator[Metric]:
    """Largest coefficient error, and whether exactly the true terms are non-zero."""
    true = true_coefficients(model, system)
    if true is None:
        return
    ours = parameters.double().numpy()[:, : len(true)]
    kept, wanted = np.abs(ours) > SMALL * np.abs(true).max(), true != 0
    false_terms = (kept & ~wanted).sum(1).astype(float)
    missing = (~kept & wanted).sum(1).astype(float)
    yield Metric(split, "coefficient_error", np.abs(ours - true).max(1), "kg, kg m, kg m^2, J")
    yield Metric(split, "false_terms", false_terms, "1")
    yield Metric(split, "missing_terms", missing, "1")
    yield Metric(split, "support_exact", ((false_terms == 0) & (missing == 0)).astype(float), "1")


def _values(features: FeatureMap, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    return features.jets(q, qd, np.zeros_like(q))[..., 0, :]
