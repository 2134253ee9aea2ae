"""Problem (9) in do-mpc (Fiedler et al. 2023, doi:10.1016/j.conengprac.2023.105676), through its public interface."""

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from repro.control.geometry import distances_squared
from repro.control.optimal_control_problem import NodeWeights, OptimalControlProblem, by_name
from repro.control.predictive_model import PredictiveModel


@dataclass(frozen=True)
class Collocation:
    """Gauss-Radau collocation of a degree on `elements` elements of every interval.

    implicit: the accelerations are algebraic variables of (7b), as in do-mpc's example of a double pendulum; else the
    variables are states and force, with the mass matrix inverted in closed form, which is quicker.
    """

    degree: int
    elements: int
    implicit: bool = False

    @property
    def label(self) -> str:
        """Degree x elements."""
        return f"Radau {self.degree} x {self.elements}"


@dataclass(frozen=True)
class DoMpc:
    """The same horizon, costs, limits and soft obstacle by collocation, solved by IPOPT with its MUMPS."""

    model: PredictiveModel
    problem: OptimalControlProblem
    weights: np.ndarray
    x_des: float
    collocation: Collocation
    tolerance: float  # of IPOPT, as the iterations
    iterations: int

    @cached_property
    def controller(self) -> Any:
        """do-mpc's controller, ready for its first step."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of its optional features
            import do_mpc

        model = do_mpc.model.Model("continuous", "SX")
        x, f = model.set_variable("_x", "x", (2 * self.model.n_q, 1)), model.set_variable("_u", "f")
        if self.collocation.implicit:
            qdd = model.set_variable("_z", "qdd", (self.model.n_q, 1))
            model.set_rhs("x", ca.vertcat(x[self.model.n_q :], qdd))
            model.set_alg("motion", self.model.inverse(x, qdd, f, self.weights))
        else:
            model.set_rhs("x", self.model.derivative(x, f, self.weights))
        model.setup()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a missing penalty on changes of the input, which (9) does not have
            return self._set_up(do_mpc.controller.MPC(model), model.x["x"], model.u["f"])

    def start(self, state: np.ndarray) -> None:
        """Begin at a state (2 n_q,), which is the first guess of the whole horizon."""
        self.controller.x0 = state
        self.controller.set_initial_guess()

    def force(self, state: np.ndarray) -> float:
        """The force, N, of one step."""
        return float(self.controller.make_step(state[:, None])[0, 0])

    @property
    def plan(self) -> tuple[np.ndarray, np.ndarray]:
        """States (nodes, 2 n_q) and forces (nodes - 1, 1) of the last solution."""
        solution, count = self.controller.opt_x_num, len(self.problem.intervals)
        scale = np.asarray(self.controller._x_scaling.cat).ravel()
        states = [np.asarray(solution["_x", k, 0, -1]).ravel() * scale for k in range(count + 1)]
        return np.stack(states), np.array([[float(solution["_u", k, 0])] for k in range(count)])

    def _set_up(self, mpc: Any, x: ca.SX, f: ca.SX) -> Any:
        problem, n_q = self.problem, self.model.n_q
        settings = mpc.settings
        settings.n_horizon, settings.t_step = len(problem.intervals), problem.time_step
        settings.state_discretization, settings.collocation_type = "collocation", "radau"
        settings.collocation_deg, settings.collocation_ni = self.collocation.degree, self.collocation.elements
        settings.store_full_solution = False
        limits = {"ipopt.tol": self.tolerance, "ipopt.max_iter": self.iterations}
        settings.nlpsol_opts = {**limits, "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0}
        mpc.set_objective(mterm=self._cost(problem.terminal_cost, x, 0.0), lterm=self._cost(problem.stage_cost, x, f))
        mpc.set_rterm(f=0.0)
        for side, sign in (("lower", -1.0), ("upper", 1.0)):
            mpc.bounds[side, "_u", "f"] = sign * np.asarray(problem.force_limit)
            if problem.speed_limit is not None:
                unlimited = np.full(n_q, np.inf)
                mpc.bounds[side, "_x", "x"] = sign * np.append(unlimited, np.full(n_q, problem.speed_limit))
        mpc.setup()
        return mpc

    def _cost(self, weights: NodeWeights, x: ca.SX, force: Any) -> ca.SX:
        kinetic, potential = self.model.energy(x, self.weights)
        cost: ca.SX = weights.kinetic * kinetic + weights.potential * self.model.potential_cost(potential)
        (position,), (push,) = (by_name(weight, [""], [True]) for weight in (weights.position, weights.force))
        cost += position * (x[0] - self.x_des) ** 2 + push * force**2
        obstacle = self.problem.obstacle
        if obstacle is None:
            return cost
        shapes = self.model.system.shapes(ca.vertsplit(x[: self.model.n_q]), ca)
        distances = ca.vertcat(*distances_squared(shapes, obstacle.centre, ca))
        penalty: ca.SX = obstacle.weight * ca.sumsqr(ca.fmax(obstacle.clearance_squared - distances, 0))
        return cost + penalty
