"""Model predictive control by problem (9), with a fixed model or one that is re-identified online."""

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Literal

import numpy as np

from repro.control.adaptation import AdaptiveController, Identification, MomentumBalance, Prior
from repro.control.closed_loop import SUBSTEPS
from repro.control.conditions import sensor_errors
from repro.control.controller import Controller, ControllerOptions, MakeController, Samples
from repro.control.geometry import Disc
from repro.control.goal import Goal
from repro.control.iterated_identification import IteratedIdentification
from repro.control.optimal_control_problem import (
    AngleError,
    Discretisation,
    NodeWeights,
    Obstacle,
    OptimalControlProblem,
    PotentialGoal,
    SolverName,
)
from repro.control.predictive_controller import PredictiveController
from repro.control.predictive_model import PredictiveModel
from repro.control.solver import Limits, make_solver
from repro.control.state_filter import FilteredIdentification
from repro.control.transcription import Transcription
from repro.mechanics.system import System
from repro.plugins.options import Count, Natural, NotNegative, Positive

STAGE_COST = NodeWeights(potential=1.0, position=1.0)
TERMINAL_COST = NodeWeights(kinetic=1.0, potential=1.0)


@dataclass(frozen=True, kw_only=True)
class Options(ControllerOptions):
    """Options of a predictive controller: what each is stands in conf/control/_mpc.yaml."""

    intervals: Count = 20
    coarse_intervals: Natural = 0
    coarse_step: Positive = 0.08
    stage_cost: NodeWeights = STAGE_COST
    terminal_cost: NodeWeights = TERMINAL_COST
    angle_error: AngleError = "cosine"
    potential_goal: PotentialGoal = "maximum"
    speed_limit: Positive | None = 45.0
    clearance_radii: Positive = 1.05
    obstacle_constraint: bool = False
    obstacle_weight: Positive = 1e6
    midpoints: bool = True
    discretisation: Discretisation = "shooting"
    solver: SolverName = "fatrop"
    tolerance: Positive = 1e-4
    iterations: Count = 40
    seconds: Positive = 0.25
    adaptive: bool = False
    prior_error: Positive = 0.2
    prior_friction: Positive = 0.3
    noise: Positive = 2e-3
    drift: Positive = 2e-4
    renewal: NotNegative = 0.0
    estimator: Literal["balance", "filter"] = "balance"
    sensor_noise: Positive = 1.0

    @property
    def adapts(self) -> bool:
        """Whether it re-identifies the weights of the model."""
        return self.adaptive

    def problem(self, disc: Disc | None, system: System) -> OptimalControlProblem:
        """Problem (9) for a system, with a disc to avoid or without."""
        avoided = self.clearance_radii, self.obstacle_constraint, self.obstacle_weight, self.midpoints
        obstacle = None if disc is None else Obstacle(disc.centre, disc.radius, *avoided)
        return OptimalControlProblem(
            intervals=(self.time_step,) * self.intervals + (self.coarse_step,) * self.coarse_intervals,
            stage_cost=self.stage_cost,
            terminal_cost=self.terminal_cost,
            obstacle=obstacle,
            force_limit=self.limits(system),
            speed_limit=self.speed_limit,
            angle_error=self.angle_error,
            potential_goal=self.potential_goal,
        )

    def problems(self, system: System) -> Iterator[str]:
        """Weights of coordinates and inputs that the system does not have; a filter of what does not adapt."""
        if self.estimator == "filter" and not self.adaptive:
            yield "control.estimator=filter re-identifies the model: use control.adaptive=true"
        has = {"position": [c.name for c in system.coordinates], "force": [each.name for each in system.inputs]}
        for cost in ("stage_cost", "terminal_cost"):
            for key, names in has.items():
                weight = getattr(getattr(self, cost), key)
                for name in set(weight) - {*names} if isinstance(weight, Mapping) else ():
                    yield f"control.{cost}.{key}.{name}: system={system.name} has {', '.join(names)}"


@contextmanager
def build(options: Options, model: PredictiveModel, disc: Disc | None, samples: Samples) -> Iterator[MakeController]:
    """Makes predictive controllers that share one problem and one solver."""
    transcription = Transcription(model, options.problem(disc, model.system), options.discretisation)
    limits = Limits(options.tolerance, options.iterations, options.seconds)
    balance = MomentumBalance(model.model, model.system, SUBSTEPS, options.time_step / SUBSTEPS)

    with closing(make_solver(transcription, options.solver, limits)) as solver:

        def make(weights: np.ndarray, goal: Goal) -> Controller:
            controller = PredictiveController(transcription, solver, weights, goal.q)
            if not options.adaptive:
                return controller
            prior = Prior.of(model.model, weights, samples, options.prior_error, options.prior_friction)
            known = balance, prior, options.noise, options.drift, options.renewal
            if options.estimator == "balance":
                kind = Identification if balance.is_linear else IteratedIdentification
                return AdaptiveController(controller, kind(*known))
            sensors = options.sensor_noise * sensor_errors(model.system)
            return AdaptiveController(controller, FilteredIdentification(*known, sensors=sensors))

        yield make
