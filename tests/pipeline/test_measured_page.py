"""The numbers of docs/measured-data.md: those of published runs are theirs, the others come out again."""

import re
import runpy

import numpy as np
import pytest
from cart_task import random_start
from simulated import random_force

from repro.config.places import ROOT
from repro.control.adaptation import Identification, MomentumBalance, Prior, sampled
from repro.control.conditions import measured, sensor_errors
from repro.control.state_filter import FilteredIdentification
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System, load
from repro.models.kinds.truth import Truth

PAGE = (ROOT / "docs" / "measured-data.md").read_text()
SCRIPT = ROOT / "docs" / "measured.py"
DT, SUBSTEPS, STEPS = 0.005, 8, 200  # of the motion beside a controller: s, per step of the controller, steps


def test_the_page_shows_the_numbers_of_the_committed_results() -> None:
    """Otherwise run `python docs/measured.py`."""
    assert runpy.run_path(str(SCRIPT))["main"](["--check"]) == 0, "run `python docs/measured.py`"


def test_a_setting_of_several_runs_is_refused() -> None:
    script = runpy.run_path(str(SCRIPT))
    runs = script["Runs"](script["RESULTS"])
    with pytest.raises(ValueError, match="runs of experiment=measured have"):
        runs.one({}, system="sip")


@pytest.mark.parametrize(
    ("system", "scenario", "bar", "seconds"),
    [("sip", "B", 0.03, 20), ("sip", "D", 0.05, 20), ("dip", "B", 0.15, 60), ("dip", "D", 0.2, 60)],
)
def test_published_networks_are_accurate(system: str, scenario: str, bar: float, seconds: float) -> None:
    script = runpy.run_path(str(SCRIPT))
    runs = script["Runs"](script["RESULTS"])
    path = runs.path(scenario, system, "structured")
    if path is None:
        pytest.skip("not among the published runs")
    assert runs.of(path, "mae_qdd").max() < bar
    assert runs.of(path, "trapped").sum() == 0
    assert runs.of(path, "fit_seconds").mean() < seconds


@pytest.mark.parametrize(("value", "text"), [(0.0, "0"), (4.74e-4, "4.7e-4"), (9.99e-4, "0.001"), (1406.2, "1400")])
def test_numbers_have_two_digits(value: float, text: str) -> None:
    assert runpy.run_path(str(SCRIPT))["shown"](value) == text


@pytest.mark.slow
@pytest.mark.parametrize(("name", "title"), [("sip", "single pendulum"), ("dip", "double pendulum")])
def test_re_identification_beside_a_controller(name: str, title: str) -> None:
    """The table of the estimators, to 10 %."""
    for estimator, found in zip(("balance", "filter"), re_identified(name), strict=True):
        (row,) = re.findall(rf"^\| {title}: {estimator} \|(.+)\|$", PAGE, re.MULTILINE)
        np.testing.assert_allclose(found, [float(cell) for cell in row.split("|")], rtol=0.1)


def re_identified(name: str) -> np.ndarray:
    """Medians of three runs: relative errors of qdd (balance and filter, after 1, 2, 4, 8 s)."""
    system = load(name)
    known = random_force(
        system, seeds=[0], samples=1000, train_fraction=0.8, episode_steps=50, force_limit=4.0, reset="random"
    )
    samples = known.q[0], known.qd[0], known.qdd[0]
    return np.median([_errors(system, samples, seed) for seed in range(3)], axis=0)


def _errors(system: System, samples: tuple[np.ndarray, ...], seed: int) -> np.ndarray:
    model, start = Truth(system), random_start(system, 0.8, seed, 0)
    right, draw = model.coefficients, np.random.default_rng([*start.seed, 1])
    weights = right * draw.uniform(0.8, 1.2, len(right))
    prior = Prior.of(model, weights, samples, 0.2, 0.3)
    momentum = MomentumBalance(model, system, SUBSTEPS, DT)
    estimators = (
        Identification(momentum, prior, 2e-3, 2e-4),
        FilteredIdentification(momentum, prior, 2e-3, 2e-4, sensors=sensor_errors(system)),
    )
    force = np.repeat(draw.uniform(-4, 4, STEPS), SUBSTEPS)[:, None]
    tau = force[None] * np.eye(system.n_q)[0]
    states = simulate(dynamics_of(system).acceleration, start.state[None], tau, DT, angles=system.angles)[0]
    seen = measured(states, system, 1.0, draw)
    errors = []
    for step in range(STEPS):
        first = step * SUBSTEPS
        for each in estimators:
            each.update(seen[first : first + SUBSTEPS + 1], force[first : first + SUBSTEPS])
        if step + 1 in (25, 50, 100, 200):
            errors.append([_error(model, samples, each.weights) for each in estimators])
    return np.transpose(errors)


def _error(model: Truth, samples: tuple[np.ndarray, ...], weights: np.ndarray) -> float:
    """The mean error of qdd over the mean of qdd, for the forces of these samples."""
    q, qd, qdd = samples
    forces = sampled(model, model.inverse_dynamics, samples, model.coefficients)
    rest = sampled(model, model.inverse_dynamics, (q, qd, np.zeros_like(qdd)), weights)
    mass = sampled(model, model.mass_matrix, (q, qd), weights).reshape(-1, model.n_q, model.n_q)
    found = np.linalg.solve(mass, (forces - rest)[..., None])[..., 0]
    return float(np.abs(found - qdd).mean() / np.abs(qdd).mean())
