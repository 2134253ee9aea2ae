"""Fits from what sensors record reach the Cramer-Rao bound, and their standard errors cover the truth."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from simulated import random_force

from repro.data.dataset import Dataset
from repro.evaluation.predictions import predict
from repro.evaluation.uncertainty import Uncertainty, expected_errors, in_words
from repro.learning.objective import Objective
from repro.learning.objectives import balance
from repro.learning.objectives.balance import balance_task
from repro.learning.optimisers.least_squares import LeastSquares
from repro.learning.path.path_fit import PathFit, PathOptions, fit_path
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import fxf, t1
from repro.models.lagrangian import Lagrangian

STATES = {"measured": "states", "q_noise": 1e-3, "qd_noise": 1e-2, "episode_steps": 50}
ENCODERS = {
    "measured": "positions", "quantisation": (1e-4, 2 * np.pi / 4096), "sample_step": 0.01, "episode_steps": 200
}  # fmt: skip
POSITIONS = {"measured": "positions", "q_noise": 1e-3, "sample_step": 0.01, "episode_steps": 200}
FORCES = STATES | {"force_noise": 0.1}
SEEDS = range(300, 304)
BARS = [
    ("sip", STATES, 1e-3),
    ("sip", ENCODERS, 3e-4),
    ("sip", POSITIONS, 1.5e-3),
    ("sip", FORCES, 0.01),
    ("dip", STATES, 5e-3),
    ("dip", ENCODERS, 3e-3),
    ("dip", POSITIONS, 8e-3),
    ("dip", FORCES, 0.015),
]


def _balanced(
    system: str, sensors: dict[str, object], seeds: Sequence[int], samples: int
) -> tuple[Lagrangian, Dataset, np.ndarray]:
    """A model of the system, recordings, and the weights (member, n_parameters) of the momentum balance."""
    whole = samples + samples // 2
    data = random_force(
        load(system), seeds=seeds, samples=whole, train_fraction=samples / whole, reset="random", labels="smoothed",
        **sensors,
    )  # type: ignore[arg-type]  # fmt: skip
    basis, n_q = (t1, 2) if system == "sip" else (fxf, 3)
    model = Lagrangian(basis, n_q)
    task = balance_task(model, data.train, Objective(balance.Options()), 0.2)
    start = LeastSquares(cutoff=1e-5).fit(
        TrainingProblem(model, [task], seeds), np.zeros((len(seeds), model.n_parameters)), silent, NoCheckpoint()
    )
    return model, data, np.asarray(start.parameters)


def _fitted(
    system: str, sensors: dict[str, object], seed: int, samples: int, noise_factor: float | None = None
) -> tuple[Lagrangian, Dataset, PathFit]:
    """noise_factor: noise levels are estimated, from the true ones times this."""
    model, data, starts = _balanced(system, sensors, [seed], samples)
    train, options = data.train, PathOptions()
    if noise_factor is not None:
        known = train.measurement
        assert known is not None
        wrong = {"q_noise": noise_factor * known.q_noise}
        if known.qd_noise is not None:
            wrong["qd_noise"] = noise_factor * known.qd_noise
        train, options = replace(train, measurement=replace(known, **wrong)), PathOptions(noise="estimated")
    return model, data, fit_path(model, train, 0, starts, options, silent)


@pytest.mark.slow
@pytest.mark.parametrize(("system", "sensors", "bar"), BARS)
def test_every_fit_is_accurate_and_at_the_bound(system: str, sensors: dict[str, object], bar: float) -> None:
    errors, bounds = [], []
    for seed in SEEDS:
        model, data, found = _fitted(system, sensors, seed, 8000)
        test = data.test
        terms = predict(model, found.parameters[None], test.q, test.qd, test.qdd, test.tau)
        errors.append(np.abs(terms.acceleration - test.qdd).mean())
        known = Uncertainty.of(found.information)
        bounds.append(expected_errors(model, found.parameters, known, 0, test)[1])
        assert found.cost_per_dof == pytest.approx(1, abs=0.05)
    assert max(errors) < bar
    assert 0.5 < np.median(errors) / np.median(bounds) < 2


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.1, 10.0])
@pytest.mark.parametrize("sensors", [STATES, POSITIONS])
@pytest.mark.parametrize("system", ["sip", "dip"])
def test_noise_levels_are_found_from_ones_that_are_wrong(
    system: str, sensors: dict[str, object], factor: float
) -> None:
    for seed in SEEDS:
        model, _, found = _fitted(system, sensors, seed, 8000, factor)
        levels = np.repeat([sensors[name] for name in ("q_noise", "qd_noise") if name in sensors], model.n_q)
        np.testing.assert_allclose(found.noise, levels, rtol=0.05)


@pytest.mark.slow
def test_intervals_cover_the_truth() -> None:
    true = np.array([0.4, 0.025, 0.1, 0.98])
    model, data, starts = _balanced("sip", POSITIONS, range(400, 500), 2000)  # smoothed together: a third of the time
    inside = []
    for member, start in enumerate(starts):
        found = fit_path(model, data.train, member, start[None], PathOptions(), silent)
        inside.append(np.abs(found.parameters - true) < 1.96 * Uncertainty.of(found.information).standard_errors)
    assert 0.9 <= np.mean(inside) <= 0.99


def test_what_is_not_determined_is_named() -> None:
    information = np.diag([4.0, 9.0, 0.0, 1.0])
    information[:2, :2] += 6.0
    known, seen = Uncertainty.of(information), [0, 1, 3]
    assert np.isinf(known.standard_errors[2])
    inverse = np.linalg.inv(information[np.ix_(seen, seen)])
    np.testing.assert_allclose(known.standard_errors[seen] ** 2, inverse.diagonal())
    assert known.identified(("a", "b", "c", "d"), 3).words == ("c",)
    np.testing.assert_allclose(known.least_known[2:], 0, atol=1e-12)


def test_without_information_nothing_is_determined() -> None:
    known = Uncertainty.of(np.zeros((4, 4)))
    assert np.isinf(known.standard_errors).all()
    np.testing.assert_array_equal(known.least_known, 0)
    words = in_words(Lagrangian(t1, 2), np.ones(4), np.zeros((4, 4)), 3)
    assert all("not determined" in text for name, text in words.items() if not name.startswith("not determined"))
