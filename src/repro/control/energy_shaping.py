"""The classical comparator: energy shaping under partial feedback linearisation, then an LQR near upright.

Spong (1995), "The swing up control problem for the Acrobot"; Tedrake, Underactuated Robotics, section 3.6. It knows the
true system, and nothing of an obstacle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from repro.control.controller import ControlStep
from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System


@dataclass(frozen=True)
class Gains:
    """Of the swing-up (energy, position, speed), and of the LQR (weights of the state and of the force).

    The LQR takes over within `angle` rad of upright at less than `rate` rad/s.
    """

    energy: float = 10.0
    position: float = 4.0
    speed: float = 3.0
    state: Sequence[float] = (10.0, 10.0, 1.0, 1.0)
    force: float = 1.0
    angle: float = 0.4
    rate: float = 3.0


@dataclass
class EnergyShaping:
    """Swings up one link and holds it at x_des; UserError for a system with more links."""

    system: System
    x_des: float
    force_limit: float = 4.0
    time_step: float = 0.04
    gains: Gains = field(default_factory=Gains)

    def __post_init__(self) -> None:
        if self.system.n_q != 2:
            raise UserError(f"control.kind = 'energy_shaping': swings up one link, and {self.system.name} has more")
        self._dynamics = dynamics_of(self.system)
        self._feedback = lqr(self.system, self.gains, self.time_step)
        at_rest = np.zeros(2)
        self._energy_up = float(self._dynamics.potential(self.system.upright, at_rest, []))

    def decide(self, state: np.ndarray) -> ControlStep:
        """The force for a state (4,)."""
        error = state - np.concatenate([self.system.upright, np.zeros(2)])
        error[0] -= self.x_des
        error[1] = (error[1] + np.pi) % (2 * np.pi) - np.pi
        if abs(error[1]) < self.gains.angle and abs(error[3]) < self.gains.rate:
            force = -float(self._feedback @ error)
        else:
            force = self._swing(state, error)
        return ControlStep(float(np.clip(force, -self.force_limit, self.force_limit)))

    def observe(self, samples: np.ndarray, forces: np.ndarray) -> None:
        """Nothing is learned from what happens."""

    def _swing(self, state: np.ndarray, error: np.ndarray) -> float:
        q, qd = state[:2], state[2:]
        mass = np.asarray(self._dynamics.mass_matrix(q, qd, []))
        energy = 0.5 * mass[1, 1] * qd[1] ** 2 + float(self._dynamics.potential(q, qd, [])) - self._energy_up
        # the cart's acceleration does the work -M_12 xdd thd on the link
        pumping = self.gains.energy * energy * np.sign(mass[0, 1]) * abs(np.cos(q[1])) * qd[1]
        wanted = pumping - self.gains.position * error[0] - self.gains.speed * error[2]
        free = np.asarray(self._dynamics.inverse(q, qd, [wanted, 0.0], [])).ravel()
        turning = -free[1] / mass[1, 1]
        return float(np.asarray(self._dynamics.inverse(q, qd, [wanted, turning], [])).ravel()[0])


def lqr(system: System, gains: Gains, time_step: float) -> np.ndarray:
    """Feedback (2 n_q,) of the linear-quadratic regulator at upright, the force held over each time step of s."""
    from scipy.linalg import expm, solve_discrete_are

    n_q = system.n_q
    x, f = ca.SX.sym("x", 2 * n_q), ca.SX.sym("f")
    tau = ca.SX(ca.DM(system.input_map)) @ f
    rate = ca.vertcat(x[n_q:], dynamics_of(system).acceleration(x[:n_q], x[n_q:], tau, ca.SX(0, 1)))
    linear = ca.Function("linear", [x, f], [ca.jacobian(rate, x), ca.jacobian(rate, f)])
    a, b = (np.asarray(part) for part in linear(np.concatenate([system.upright, np.zeros(n_q)]), 0.0))
    held = expm(np.block([[a, b], [np.zeros((1, 2 * n_q + 1))]]) * time_step)
    a, b = held[:-1, :-1], held[:-1, -1:]
    cost = np.diag(np.asarray(gains.state, dtype=float))
    value = solve_discrete_are(a, b, cost, np.array([[gains.force]]))
    return np.asarray(np.linalg.solve(gains.force + b.T @ value @ b, b.T @ value @ a)[0])
