"""From plain options to controllers: what conf/control says."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from repro.control.adaptation import Identification, Prior
from repro.control.adaptive_controller import AdaptiveController
from repro.control.closed_loop import SUBSTEPS
from repro.control.controller import Controller
from repro.control.energy_shaping import EnergyShaping
from repro.control.momentum_balance import MomentumBalance
from repro.control.nonlinear_solver import Solver
from repro.control.optimal_control_problem import NodeWeights, Obstacle, OptimalControlProblem
from repro.control.predictive_controller import PredictiveController
from repro.control.predictive_model import PredictiveModel
from repro.control.solver import Limits, make_solver
from repro.control.transcription import Transcription

Samples = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Setting:
    """Makes the controllers of one setting for one model; what is costly is made once and shared.

    obstacle: the disc that is there. samples: q, qd, qdd (sample, n_q) of the training data, which the prior of an
    adaptive controller is made from.
    """

    options: Mapping[str, Any]
    model: PredictiveModel
    obstacle: Obstacle | None
    samples: Samples

    @cached_property
    def problem(self) -> OptimalControlProblem:
        """Problem (9) of a predictive controller."""
        options = self.options
        early = (options["time_step"],) * options["intervals"]
        return OptimalControlProblem(
            intervals=early + (options["coarse_step"],) * options["coarse_intervals"],
            stage_cost=NodeWeights(**options["stage_cost"]),
            terminal_cost=NodeWeights(**options["terminal_cost"]),
            obstacle=self.obstacle,
            force_limit=options["force_limit"],
            speed_limit=options["speed_limit"],
            angle_error=options["angle_error"],
        )

    @cached_property
    def transcription(self) -> Transcription:
        """The problem in its discretisation."""
        return Transcription(self.model, self.problem, self.options["discretisation"])

    @cached_property
    def solver(self) -> Solver:
        """The solver, ready."""
        limits = Limits(*(self.options[name] for name in ("tolerance", "iterations", "seconds")))
        return make_solver(self.transcription, self.options["solver"], limits)

    @cached_property
    def balance(self) -> MomentumBalance:
        """What an adaptive controller learns from: every sub-step of a control step."""
        dt = self.options["time_step"] / SUBSTEPS
        return MomentumBalance(self.model.model, self.model.system, SUBSTEPS, dt)

    def controller(self, weights: np.ndarray, x_des: float) -> Controller:
        """A controller with a model of these weights that leads the cart to x_des."""
        options = self.options
        if options["kind"] == "energy_shaping":
            return EnergyShaping(self.model.system, x_des, options["force_limit"], options["time_step"])
        made = PredictiveController(self.transcription, self.solver, weights, x_des)
        if not options["adaptive"]:
            return made
        expected = options["prior_error"], options["prior_friction"]
        prior = Prior.of(self.model.model, weights, *self.samples, *expected)
        return AdaptiveController(made, Identification(self.balance, prior, options["noise"], options["drift"]))

    def close(self) -> None:
        """End the solver's process, where there is one."""
        if self.options["kind"] == "mpc":
            self.solver.close()
