"""The path fit: its filter is the dense least-squares problem, its steps have the right derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from optional import needs_compiler
from simulated import random_force

from repro.data.dataset import Dataset
from repro.learning.path import path_fit
from repro.learning.path.kalman import Linearised, smoothed, whitened
from repro.learning.path.path_fit import MemberPath, PathOptions, fit_path
from repro.learning.path.windows import Windows
from repro.learning.result import silent
from repro.mechanics.system import load
from repro.models.bases import t1
from repro.models.damped import Damped
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.step_model import StepModel

SYSTEM = load("sip")
TRUE = np.array([0.4, 0.025, 0.1, 0.98])
START = TRUE[None] * 1.05
MODELS = {
    "linear": (Lagrangian(t1, 2), TRUE),
    "damped": (Damped(Lagrangian(t1, 2), "diagonal"), np.append(TRUE, [0.3, 0.002])),
    "network": (Structured(2, np.array([1.0, 3.0]), structured.Options(hidden=(2,))), None),
}


def _data(samples: int = 600, **options: object) -> Dataset:
    chosen = {"measured": "positions", "labels": "smoothed", "q_noise": 1e-3, "sample_step": 0.02} | options
    return random_force(SYSTEM, seeds=[1], samples=samples, episode_steps=100, reset="random", **chosen).train  # type: ignore[arg-type]


def _weights(name: str) -> tuple[Model, np.ndarray]:
    model, weights = MODELS[name]
    return model, model.initial([np.random.default_rng(0)])[0] if weights is None else weights


@pytest.mark.parametrize("name", MODELS)
def test_steps_are_differentiated_and_need_no_compiler(name: str) -> None:
    model, weights = _weights(name)
    draw = np.random.default_rng(0)
    states, tau, step = draw.normal(size=(5, 4)), draw.normal(size=(5, 2)), np.full(5, 0.04)
    found = StepModel(model)(states, tau, step, weights, 3)
    slow = StepModel(model, compiled=False)(states, tau, step, weights, 3)
    for ours, plain in zip(vars(found).values(), vars(slow).values(), strict=True):
        np.testing.assert_allclose(ours, plain, rtol=1e-9, atol=1e-11)
    h = 1e-6
    for part, slope in (
        ("by_state", found.by_state),
        ("by_weights", found.columns[..., 1:]),
        ("by_force", found.by_force),
    ):
        direction = draw.normal(size=slope.shape[-1])
        moves = [
            (
                states + sign * h * direction if part == "by_state" else states,
                tau + sign * h * direction if part == "by_force" else tau,
                weights + sign * h * direction if part == "by_weights" else weights,
            )
            for sign in (1, -1)
        ]
        ahead, behind = (StepModel(model)(x, u, step, w, 3).states for x, u, w in moves)
        np.testing.assert_allclose(slope @ direction, (ahead - behind) / (2 * h), atol=2e-7)


@needs_compiler
@pytest.mark.parametrize("name", MODELS)
def test_steps_are_compiled_where_a_compiler_is(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The interpreted steps give the same values an order of magnitude more slowly, so that nothing else shows them."""
    monkeypatch.setattr(StepModel, "_some", lambda *_: pytest.fail("interpreted"))
    model, weights = _weights(name)
    assert StepModel(model)(np.zeros((5, 4)), np.zeros((5, 2)), np.full(5, 0.04), weights, 3).states.shape == (5, 4)


def _dense(windows: Windows, linear: Linearised, initial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All residuals of one window as rows [constant | unknowns]: starts, process noise, force errors and weights."""
    length, n_x = linear.states.shape[1:]
    n_w, n_q = linear.columns.shape[3] - 1, windows.n_q
    n = n_x + (length - 1) * (n_x + n_q) + n_w
    state = np.zeros((n_x, 1 + n))
    state[:, 1 : 1 + n_x] = np.diag(np.sqrt(initial))
    rows = [np.eye(1 + n)[1 : 1 + n - n_w]]
    for k in range(length):
        sensors = windows.measured.shape[2]
        error = -state[:sensors].copy()
        error[:, 0] += windows.measured[0, k] - linear.states[0, k, :sensors]
        rows.append(error[np.isfinite(error[:, 0])] / np.sqrt(windows.variance)[np.isfinite(error[:, 0]), None])
        if k + 1 < length:
            at = 1 + n_x + k * (n_x + n_q)
            state = linear.by_state[0, k] @ state
            state[:, 0] += linear.columns[0, k, :, 0]
            state[:, 1 + n - n_w :] += linear.columns[0, k, :, 1:]
            state[:, at : at + n_x] += np.diag(np.sqrt(linear.process))
            state[:, at + n_x : at + n_x + n_q] += linear.by_force[0, k] * np.sqrt(windows.force_variance)
    whole = np.concatenate(rows)
    return whole[:, 0], whole[:, 1:]


@pytest.mark.parametrize("missing", [False, True])
def test_the_filter_is_the_dense_least_squares_problem(missing: bool) -> None:
    draw = np.random.default_rng(4)
    length, n_x, n_w = 6, 4, 3
    measured = draw.normal(size=(1, length, 3))
    if missing:
        measured[0, 2] = measured[0, 4, 1] = np.nan
    step = np.append(np.ones(length - 1), np.nan)[None]
    windows = Windows(
        np.zeros(length, int), np.arange(length), measured, step, np.array([0.1, 0.2, 0.3]), np.array([0.5, 0.0]), 2
    )
    linear = Linearised(
        draw.normal(size=(1, length, n_x)), draw.normal(size=(1, length, n_x, n_x)),
        draw.normal(size=(1, length, n_x, 2)), draw.normal(size=(1, length, n_x, 1 + n_w)), np.full(n_x, 0.01),
    )  # fmt: skip
    initial = np.array([1.0, 1.0, 9.0, 9.0])
    rows = whitened(windows, linear, initial)
    constant, matrix = _dense(windows, linear, initial)
    for change in (np.zeros(n_w), np.array([0.3, -1.0, 0.2])):
        free, fixed = matrix[:, :-n_w], constant + matrix[:, -n_w:] @ change
        best = np.linalg.lstsq(free, -fixed, rcond=None)[0]
        profile = ((fixed + free @ best) ** 2).sum()
        assert ((rows[:, 0] + rows[:, 1:] @ change) ** 2).sum() == pytest.approx(profile)
        path = smoothed(windows, linear, change, initial)
        np.testing.assert_allclose(path.deviations[0, 0], np.sqrt(initial) * best[:n_x], atol=1e-9)
        errors = best[n_x:].reshape(length - 1, n_x + 2)[:, n_x:] * np.sqrt(windows.force_variance)
        np.testing.assert_allclose(path.force_errors[0, :-1], errors, atol=1e-9)


@pytest.mark.parametrize("options", [{}, {"measured": "states", "qd_noise": 1e-2}, {"force_noise": 0.1}])
def test_the_coefficients_are_found_within_their_standard_errors(options: dict[str, object]) -> None:
    data = _data(1500, **options)
    found = fit_path(Lagrangian(t1, 2), data, 0, START, PathOptions(), silent)
    errors = np.sqrt(np.linalg.inv(found.information).diagonal())
    assert np.abs((found.parameters - TRUE) / errors).max() < 4
    assert np.abs(found.parameters / TRUE - 1).max() < 0.02
    assert found.cost_per_dof == pytest.approx(1, abs=0.15)


def test_gaps_missing_samples_and_uneven_stamps_are_used_as_they_are() -> None:
    data = _data(1500)
    assert data.measurement is not None
    keep = np.random.default_rng(0).random(data.samples) > 0.15
    keep &= (np.arange(data.samples) % 100 < 40) | (np.arange(data.samples) % 100 > 60)
    held = np.repeat(data.tau[:, ::2], 2, axis=1)[:, : data.samples]
    np.testing.assert_array_equal(held, data.tau)  # a force is held for two samples, so a lost second one loses nothing
    keep[::2] = True
    q = data.measurement.q.copy()
    q[:, 5::17] = np.nan
    thinned = replace(data, measurement=replace(data.measurement, q=q)).select(np.flatnonzero(keep), int(keep.sum()))
    found = fit_path(Lagrangian(t1, 2), thinned, 0, START, PathOptions(), silent)
    errors = np.sqrt(np.linalg.inv(found.information).diagonal())
    assert np.abs((found.parameters - TRUE) / errors).max() < 4


def test_unknown_noise_is_estimated() -> None:
    data = _data(1500)
    assert data.measurement is not None
    wrong = replace(data, measurement=replace(data.measurement, q_noise=np.array([1e-2, 1e-2])))
    found = fit_path(Lagrangian(t1, 2), wrong, 0, START, PathOptions(noise="estimated"), silent)
    np.testing.assert_allclose(found.noise, 1e-3, rtol=0.08)


def test_the_loss_has_the_gradient_of_the_filter() -> None:
    """By finite differences of the loss, the path being moved to the most likely one each time."""
    data, model = _data(200), Lagrangian(t1, 2)
    path = MemberPath(model, data, 0, PathOptions())
    at = TRUE * 1.01

    def profile(weights: np.ndarray) -> tuple[float, np.ndarray]:
        path.states = path.windows.cut(np.concatenate([data.q[0], data.qd[0]], axis=1))
        for _ in range(8):
            linear = path.linearised(path.states, path.tau, weights)
            path.states = path.states + smoothed(path.windows, linear, np.zeros(4), path.initial).deviations
        products = path.regression(path.linearised(path.states, path.tau, weights))
        return float(products[0, 0]), 2 * products[0, 1:]

    gradient = profile(at)[1]
    for number in range(4):
        step = np.eye(4)[number] * 1e-4 * at
        slope = (profile(at + step)[0] - profile(at - step)[0]) / (2 * step[number])
        assert slope == pytest.approx(gradient[number], rel=2e-3, abs=1.0)


def test_friction_and_the_zero_of_an_encoder_are_found() -> None:
    system = load("sip", damping=[0.3, 0.002])
    data = random_force(
        system, seeds=[1], samples=3000, episode_steps=100, reset="random", measured="positions", labels="smoothed",
        q_noise=1e-3, sample_step=0.02, encoder_zero=0.02, wrapped=True,
    ).train  # fmt: skip
    model = Damped(Lagrangian(t1, 2), "diagonal")
    start = np.append(TRUE, [0.2, 0.004])[None]
    without = fit_path(model, data, 0, start, PathOptions(), silent)
    found = fit_path(model, data, 0, start, PathOptions(zeros="angles"), silent)
    assert without.cost_per_dof > 10
    assert found.cost_per_dof == pytest.approx(1, abs=0.1)
    assert found.zeros[0] == pytest.approx(0.02, abs=4 * found.zero_errors[0])
    np.testing.assert_allclose(found.parameters[4:], [0.3, 0.002], rtol=0.03)


# the plant's weights, but for an inertia that is too small for the coupling: the mass matrix is singular near the data
AMPLIFYING = np.array([0.4, 1e-9, 1e-5, 0.98])


@pytest.mark.parametrize("unusable", [np.zeros(4), AMPLIFYING], ids=["singular", "amplifying"])
def test_a_start_that_cannot_be_linearised_gives_way_to_another(unusable: np.ndarray) -> None:
    data, model = _data(200), Lagrangian(t1, 2)
    alone = fit_path(model, data, 0, unusable[None], PathOptions(), silent)
    assert alone.status == "diverged at step 0"
    assert np.isinf(alone.cost_per_dof)
    np.testing.assert_array_equal(alone.parameters, unusable)
    beside = fit_path(model, data, 0, np.concatenate([unusable[None], START]), PathOptions(), silent)
    usual = fit_path(model, data, 0, START, PathOptions(), silent)
    assert beside.status == usual.status == "ok"
    np.testing.assert_array_equal(beside.parameters, usual.parameters)
    np.testing.assert_array_equal(beside.information, usual.information)


def test_a_step_to_where_the_motion_cannot_be_linearised_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    data, model = _data(200), Lagrangian(t1, 2)
    usual = fit_path(model, data, 0, START, PathOptions(), silent)
    astray = iter([AMPLIFYING - START[0], -START[0]])
    own = path_fit.damped_step
    monkeypatch.setattr(path_fit, "damped_step", lambda *given: next(astray, own(*given)))
    found = fit_path(model, data, 0, START, PathOptions(), silent)
    assert next(astray, None) is None
    assert found.losses[0] == usual.losses[0]
    assert found.status == "ok"
    np.testing.assert_allclose(found.parameters, usual.parameters, rtol=1e-3)


def test_a_stage_that_cannot_be_linearised_leaves_the_weights_of_the_one_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = MemberPath.linearised

    def without_noise_out_of_range(path: MemberPath, *at: np.ndarray) -> Linearised:
        linear = own(path, *at)
        return linear if path.process else replace(linear, columns=linear.columns * np.inf)

    monkeypatch.setattr(MemberPath, "linearised", without_noise_out_of_range)
    data, model = _data(200), Lagrangian(t1, 2)
    whole, first = (fit_path(model, data, 0, START, PathOptions(process=p), silent) for p in ((1.0, 0.0), (1.0,)))
    assert whole.status == f"diverged at step {len(whole.losses)}"
    assert whole.losses[-1] < whole.losses[0]
    np.testing.assert_allclose(whole.parameters, first.parameters, rtol=0.01)
    assert np.linalg.eigvalsh(whole.information)[0] > 0


@pytest.mark.parametrize(
    ("name", "process", "costs", "kept"),
    [
        ("network", None, {(1.0, 0.1, 0.0): 1.3}, 1.3),
        ("network", None, {(1.0, 0.1, 0.0): 3e9, path_fit.WIDER: 1.1}, 1.1),
        ("network", None, {(1.0, 0.1, 0.0): 5.0, path_fit.WIDER: np.inf}, 5.0),
        ("network", (1.0, 0.0), {(1.0, 0.0): 3e9}, 3e9),
        ("linear", None, {(0.0,): 3e9}, 3e9),
    ],
    ids=["explained", "better", "no better", "given stages", "closed form"],
)
def test_a_network_that_does_not_explain_the_recording_is_fitted_through_more_noise(
    name: str,
    process: tuple[float, ...] | None,
    costs: dict[tuple[float, ...], float],
    kept: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model, weights = _weights(name)
    usual = fit_path(*MODELS["linear"][:1], _data(200), 0, START, PathOptions(), silent)
    stages = []

    def through(some: tuple[float, ...], *given: object) -> path_fit.PathFit:
        stages.append(some)
        return replace(usual, cost_per_dof=costs[some])

    monkeypatch.setattr(path_fit, "_fit_through", through)
    found = fit_path(model, _data(200), 0, weights[None], PathOptions(process=process), silent)
    assert found.cost_per_dof == kept
    assert stages == list(costs)
