"""The classical comparator: energy shaping under partial feedback linearisation, then an LQR near upright.

Spong (1995), "The swing up control problem for the Acrobot"; Tedrake, Underactuated Robotics, section 3.6. It uses the
true system, and ignores obstacles.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from repro.control.controller import ControllerOptions, ControlStep, MakeController, Samples
from repro.control.geometry import Disc
from repro.control.predictive_model import PredictiveModel
from repro.errors import UserError
from repro.mechanics.chain import Chain
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import under_inputs
from repro.mechanics.system import System

ENERGY_GAIN, POSITION_GAIN, SPEED_GAIN = 10.0, 4.0, 3.0  # of the swing-up
STATE_COST, FORCE_COST = (10.0, 10.0, 1.0, 1.0), 1.0  # of the LQR
LQR_ANGLE, LQR_RATE = 0.4, 3.0  # it takes over within this of upright, in rad and rad/s


@dataclass(frozen=True, kw_only=True)
class Options(ControllerOptions):
    """Options of the classical swing-up of one link."""

    drives: ClassVar[str] = "a cart with one link by one force"

    def fits(self, system: System) -> bool:
        """Whether it can drive a system."""
        return isinstance(system, Chain) and system.n_q == 2


@contextmanager
def build(options: Options, model: PredictiveModel, disc: Disc | None, samples: Samples) -> Iterator[MakeController]:
    """Makes controllers of the true system; they use nothing else."""
    (limit,) = options.limits(model.system)
    yield lambda weights, goal: EnergyShaping(model.system, float(goal.q[0]), limit, options.time_step)


@dataclass
class EnergyShaping:
    """Swings up one link and holds it at x_des, m; UserError for a system with more links."""

    system: System
    x_des: float
    force_limit: float = 4.0
    time_step: float = 0.04

    def __post_init__(self) -> None:
        if self.system.n_q != 2:
            raise UserError(f"energy shaping drives a cart with one link; {self.system.name} has {self.system.n_q - 1}")
        self._dynamics = dynamics_of(self.system)
        self._feedback = lqr(self.system, self.time_step)
        at_rest = np.zeros(2)
        self._energy_up = float(self._dynamics.potential(self.system.at_rest(), at_rest, []))

    def decide(self, state: np.ndarray) -> ControlStep:
        """The force at a state (4,)."""
        error = state - np.concatenate([self.system.at_rest(), np.zeros(2)])
        error[0] -= self.x_des
        error[1] = (error[1] + np.pi) % (2 * np.pi) - np.pi
        if abs(error[1]) < LQR_ANGLE and abs(error[3]) < LQR_RATE:
            force = -float(self._feedback @ error)
        else:
            force = self._swing(state, error)
        return ControlStep(np.clip([force], -self.force_limit, self.force_limit))

    def observe(self, samples: np.ndarray, inputs: np.ndarray) -> None:
        """The controller stays as it is."""

    def _swing(self, state: np.ndarray, error: np.ndarray) -> float:
        q, qd = state[:2], state[2:]
        mass = np.asarray(self._dynamics.mass_matrix(q, qd, []))
        energy = 0.5 * mass[1, 1] * qd[1] ** 2 + float(self._dynamics.potential(q, qd, [])) - self._energy_up
        # the cart's acceleration does the work -M_12 xdd thd on the link
        pumping = ENERGY_GAIN * energy * np.sign(mass[0, 1]) * abs(np.cos(q[1])) * qd[1]
        cart = pumping - POSITION_GAIN * error[0] - SPEED_GAIN * error[2]
        free = np.asarray(self._dynamics.inverse(q, qd, [cart, 0.0], [])).ravel()
        turning = -free[1] / mass[1, 1]
        return float(np.asarray(self._dynamics.inverse(q, qd, [cart, turning], [])).ravel()[0])


def lqr(system: System, time_step: float) -> np.ndarray:
    """Feedback gain (2 n_q,) of the linear-quadratic regulator at upright, for a force held over each time step, s."""
    from scipy.linalg import expm, solve_discrete_are

    n_q = system.n_q
    x, f = ca.SX.sym("x", 2 * n_q), ca.SX.sym("f")
    acceleration = under_inputs(dynamics_of(system).acceleration, system)
    rate = ca.vertcat(x[n_q:], acceleration(x[:n_q], x[n_q:], f, ca.SX(0, 1)))
    linear = ca.Function("linear", [x, f], [ca.jacobian(rate, x), ca.jacobian(rate, f)])
    a, b = (np.asarray(part) for part in linear(np.concatenate([system.at_rest(), np.zeros(n_q)]), 0.0))
    held = expm(np.block([[a, b], [np.zeros((1, 2 * n_q + 1))]]) * time_step)
    a, b = held[:-1, :-1], held[:-1, -1:]
    value = solve_discrete_are(a, b, np.diag(STATE_COST), np.array([[FORCE_COST]]))
    return np.asarray(np.linalg.solve(FORCE_COST + b.T @ value @ b, b.T @ value @ a)[0])
