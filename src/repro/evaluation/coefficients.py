"""Errors of a linear basis: its coefficients, and which terms it kept."""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import block_diag, null_space

from repro.codegen.array_evaluation import evaluate
from repro.evaluation.pointwise import MetricValues
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.features import FeatureMap
from repro.models.lagrangian import Lagrangian

STATES = 500
SMALL = 1e-9


def true_coefficients(model: Lagrangian, system: System) -> np.ndarray | None:
    """Coefficients (n_parameters,) of the true T and V in the model's basis; None where they are not in its span.

    Where terms of the basis depend on each other (sin^2 + cos^2 = 1) these are the ones of least norm.
    """
    q, qd = _states(system)
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


def coefficient_errors(model: Lagrangian, parameters: np.ndarray, system: System) -> Iterator[MetricValues]:
    """Largest coefficient error, and whether exactly the true terms are non-zero.

    In a redundant basis an error counts after what the identities between its terms undo, and there is no one support.
    """
    true = true_coefficients(model, system)
    if true is None:
        return
    ours = np.asarray(parameters, dtype=float)[:, : len(true)]
    both = (model.kinetic_features, model.potential_features)
    # orthonormal combinations (k, n_parameters) of terms that vanish everywhere, in T or in V
    identities = block_diag(*(null_space(_values(features, *_states(system))).T for features in both))
    error = ours - true
    error = error - error @ identities.T @ identities
    yield MetricValues("test", "coefficient_error", np.abs(error).max(1), "kg, kg m, kg m^2, J")
    if len(identities):
        return
    kept, wanted = np.abs(ours) > SMALL * np.abs(true).max(), true != 0
    false_terms = (kept & ~wanted).sum(1).astype(float)
    missing = (~kept & wanted).sum(1).astype(float)
    yield MetricValues("test", "false_terms", false_terms, "1")
    yield MetricValues("test", "missing_terms", missing, "1")
    yield MetricValues("test", "support_exact", ((false_terms == 0) & (missing == 0)).astype(float), "1")


def _states(system: System) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(0)
    q = generator.uniform(-np.pi, np.pi, (STATES, system.n_q))
    return q, generator.normal(size=q.shape)


def _values(features: FeatureMap, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    return features.jets(q, qd, np.zeros_like(q))[..., 0, :]
