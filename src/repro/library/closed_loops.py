"""Closed loops of a fitted ensemble on a plant: what the pipeline stores, and Python code looks at."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from repro.control.closed_loop import ClosedLoop, run_loop
from repro.control.conditions import wrong_weights
from repro.control.controller import CONTROLLERS
from repro.control.predictive_model import PredictiveModel
from repro.control.task import LoopPlan
from repro.errors import UserError
from repro.learning.result import Progress, silent
from repro.library.ensemble_model import Ensemble
from repro.mechanics.system import System
from repro.plugins.plugin import plugin

PRIOR_SAMPLES = 2000


def closed_loops(
    ensemble: Ensemble, system: System, plan: LoopPlan, report: Progress = silent, first: int = 0
) -> Iterator[tuple[int, int, ClosedLoop]]:
    """Number, index of the member and loop of every closed loop of a plan on a system, from number `first` on.

    UserError for a model that has no expressions.
    """
    model, parameters = ensemble.model, ensemble.weights_
    if model.not_symbolic is not None:
        raise UserError(f"a predictive controller needs the model as expressions: {model.not_symbolic}")
    train, task, options = ensemble.data.train, plan.task, plan.controller
    samples = train.q[0][:PRIOR_SAMPLES], train.qd[0][:PRIOR_SAMPLES], train.qdd[0][:PRIOR_SAMPLES]
    disc, starts = task.disc(system), task.starts(system, len(parameters))[: plan.loops]
    lengths, bounds = {"time_step": options.time_step, "seconds": task.seconds}, task.bounds(system)
    predictive = PredictiveModel(model, system, plan.canonical)
    with plugin(CONTROLLERS, options.kind).build(options, predictive, disc, samples) as make_controller:
        for number, (start, member) in list(enumerate(starts))[first:]:
            report(number / len(starts), f"closed loop {number + 1} of {len(starts)}")
            driving = make_controller(wrong_weights(parameters[member], task, start), start.goal)
            yield number, member, run_loop(system, driving, start, task, **lengths, disc=disc, bounds=bounds)


@dataclass(frozen=True)
class Controlled:
    """Closed loops, each with its time (s), states (n, 2 n_q), inputs (n_steps, n_u) and outcome."""

    loops: Sequence[ClosedLoop] = field(repr=False)

    @property
    def success(self) -> float:
        """The share of loops that reached the goal and held it, without contact."""
        return float(np.mean([loop.outcome.success for loop in self.loops]))
