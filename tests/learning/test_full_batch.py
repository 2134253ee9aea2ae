"""What Levenberg-Marquardt and L-BFGS have in common: one member after another, on a full batch."""

import numpy as np
import pytest
import torch

from repro.codegen import c_library
from repro.learning.full_batch import merge_curves
from repro.learning.optimisers.lbfgs import LBFGS
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.models.bases import t2
from repro.models.lagrangian import Lagrangian

OPTIMISERS = {
    "levenberg_marquardt": LevenbergMarquardt(iterations=12, samples=100, restarts=2, trial_iterations=4),
    "lbfgs": LBFGS(iterations=12, samples=100),
}


@pytest.fixture(params=OPTIMISERS)
def optimiser(request):
    return OPTIMISERS[request.param]


@pytest.fixture
def t2_problem(make_problem, data):
    return make_problem(Lagrangian(t2, 2, hidden=(4,)), data)


def test_the_loss_never_rises_and_falls_far(optimiser, t2_problem, start):
    fitted = optimiser.fit(t2_problem, start(t2_problem.model), silent, NoCheckpoint())
    losses = np.array([values for _, name, values in fitted.curves if name == "loss"])
    assert np.all(np.diff(losses, axis=0) <= 0)
    assert np.all(losses[-1] < 0.5 * losses[0])
    assert fitted.status == ["ok"] * 3


def test_the_curve_ends_at_the_loss_of_the_result(optimiser, t2_problem, start):
    fitted = optimiser.fit(t2_problem, start(t2_problem.model), silent, NoCheckpoint())
    reduced = t2_problem.subsample(100)
    np.testing.assert_allclose(fitted.curves[-1][2], reduced.loss(fitted.parameters).numpy(), rtol=1e-9)


def test_members_are_independent(optimiser, t2_problem, start):
    parameters = start(t2_problem.model)
    together = optimiser.fit(t2_problem, parameters, silent, NoCheckpoint())
    alone = optimiser.fit(t2_problem.member(1), parameters[1:2], silent, NoCheckpoint())
    assert torch.equal(together.parameters[1:2], alone.parameters)


def test_a_resumed_fit_ends_at_the_same_bits(optimiser, t2_problem, start, memory):
    parameters = start(t2_problem.model)
    whole = optimiser.fit(t2_problem, parameters, silent, NoCheckpoint())
    checkpoint = memory(stop_at=2)
    with pytest.raises(KeyboardInterrupt):
        optimiser.fit(t2_problem, parameters, silent, checkpoint)
    said = []
    resumed = optimiser.fit(t2_problem, parameters, lambda fraction, text: said.append(fraction), checkpoint)
    assert torch.equal(resumed.parameters, whole.parameters)
    assert min(said) > 2 / 3  # two of three members were there


def test_a_member_that_cannot_start_is_marked_and_changes_no_bit_of_the_others(
    optimiser, data, spoilt, make_problem, start
):
    model = Lagrangian(t2, 2, hidden=(4,))
    parameters = start(model)
    everything = type(optimiser)(iterations=3, samples=None)
    healthy, sick = (
        everything.fit(make_problem(model, each), parameters, silent, NoCheckpoint()) for each in (data, spoilt)
    )
    assert sick.status == ["ok", "diverged at step 0", "ok"]
    assert torch.equal(sick.parameters[[0, 2]], healthy.parameters[[0, 2]])
    assert torch.equal(sick.parameters[1], parameters[1])


def test_a_linear_problem_is_solved(optimiser, t1_problem, start, true_t1):
    chosen = type(optimiser)(iterations=60, samples=None)
    fitted = chosen.fit(t1_problem, start(t1_problem.model), silent, NoCheckpoint())
    np.testing.assert_allclose(fitted.parameters.numpy(), np.tile(true_t1, (3, 1)), rtol=1e-5)


def test_curves_of_different_lengths_are_held_at_their_last_value():
    curve = merge_curves([{0: 4.0, 1: 2.0, 2: 1.0}, {0: 8.0}], "loss")
    assert [step for step, _, _ in curve] == [0, 1, 2]
    np.testing.assert_array_equal([values for _, _, values in curve], [[4, 8], [2, 8], [1, 8]])


@pytest.mark.parametrize("build", [LevenbergMarquardt, LBFGS])
def test_a_short_fit_runs_no_compiler_and_a_long_one_ends_at_the_same_weights(
    build, t2_problem, start, monkeypatch, tmp_path
):
    """Few steps by torch, and the same steps by compiled code, chosen where the fit may take many more."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiled = []
    original = c_library._compile
    monkeypatch.setattr(c_library, "_compile", lambda *arguments: (compiled.append(1), original(*arguments)))
    parameters = start(t2_problem.model)

    def fit(claimed):
        optimiser = build(iterations=4, **({"restarts": 1} if build is LevenbergMarquardt else {}))
        monkeypatch.setattr(build, "evaluations", claimed)
        return optimiser.fit(t2_problem, parameters, silent, NoCheckpoint()).parameters.numpy()

    short, before = fit(4), len(compiled)
    long = fit(100_000)
    assert before == 0
    if c_library.has_compiler():
        assert compiled
    np.testing.assert_allclose(long, short, rtol=1e-6, atol=1e-9)
