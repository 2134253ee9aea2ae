"""Phases in turn: weights, curves, status and checkpoints go from one to the next."""

from dataclasses import dataclass, field

import numpy as np
import pytest
import torch

from repro.learning.objective import Objective
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.optimisers.adam import Adam
from repro.learning.result import Fitted
from repro.learning.training import Phase, make_task, train
from repro.models.bases import t2
from repro.models.lagrangian import Lagrangian


@dataclass(frozen=True)
class Counting(OptimiserOptions):
    """Adds one to every weight, notes how it was called, and lets members fail as told."""

    fails: dict = field(default_factory=dict)  # call number -> status
    calls: list = field(default_factory=list)
    later: bool = False

    def fit(self, problem, parameters, progress, checkpoint):
        number = len(self.calls)
        self.calls.append((problem, self.later))
        progress(0.5, "half-way")
        status = self.fails.get(number, ["ok"] * len(parameters))
        curves = [(step, "loss", np.full(len(parameters), 10.0 * number + step)) for step in (1, 2)]
        return Fitted(parameters + 1, curves, status, {f"call {number}": number})

    def continued(self):
        return Counting(self.fails, self.calls, later=True)


@pytest.fixture
def phases(make_problem, data):
    problem = make_problem(Lagrangian(t2, 2, hidden=(4,)), data)
    return [Phase("first", problem), Phase("second", problem.subsample(50))]


def test_each_phase_starts_where_the_last_one_ended(phases):
    optimiser = Counting()
    fitted = train(phases, optimiser, torch.zeros(3, 2))
    assert torch.equal(fitted.parameters, torch.full((3, 2), 2.0))
    assert [problem for problem, _ in optimiser.calls] == [phase.problem for phase in phases]
    assert [later for _, later in optimiser.calls] == [False, True]
    assert fitted.notes == {"call 0": 0, "call 1": 1}


def test_curves_run_on(phases):
    fitted = train(phases, Counting(), torch.zeros(3, 2))
    assert [step for step, _, _ in fitted.curves] == [1, 2, 3, 4]
    assert [values[0] for _, _, values in fitted.curves] == [1, 2, 11, 12]


def test_the_first_failure_of_a_member_is_what_is_told(phases):
    fails = {0: ["ok", "diverged at epoch 3", "ok"], 1: ["ok", "diverged at epoch 9", "diverged at epoch 1"]}
    fitted = train(phases, Counting(fails), torch.zeros(3, 2))
    assert fitted.status == ["ok", "diverged at epoch 3 of first", "diverged at epoch 1 of second"]


def test_progress_is_shared_by_the_phases(phases):
    told = []
    train(phases, Counting(), torch.zeros(3, 2), lambda fraction, text: told.append((fraction, text)))
    assert told == [(0.25, "first: half-way"), (0.75, "second: half-way")]


@pytest.mark.parametrize("stop_at", [2, 4, 6])  # within the first phase, at its end, within the second
def test_a_fit_interrupted_anywhere_ends_at_the_same_bits(stop_at, phases, start, memory):
    optimiser = Adam(epochs=3, batch_size=60)
    parameters = start(phases[0].problem.model)
    whole = train(phases, optimiser, parameters)
    checkpoint = memory(stop_at)
    with pytest.raises(KeyboardInterrupt):
        train(phases, optimiser, parameters, checkpoint=checkpoint)
    resumed = train(phases, optimiser, parameters, checkpoint=checkpoint)
    assert checkpoint.saves == 8  # three epochs and an end a phase, none repeated
    assert torch.equal(resumed.parameters, whole.parameters)
    assert [step for step, _, _ in resumed.curves] == [step for step, _, _ in whole.curves] == [1, 2, 3, 4, 5, 6]


def test_the_known_energy_is_measured_where_the_data_have_it(data, free):
    model = Lagrangian(t2, 2, hidden=(4,))
    assert "energy" not in make_task(model, data.train, Objective()).measured
    assert torch.equal(make_task(model, free, Objective()).measured["energy"], torch.from_numpy(free.energy))
