"""Energy shaping of the fitted model under partial feedback linearisation, then an LQR near upright.

Spong (1995), "The swing up control problem for the Acrobot"; Tedrake, Underactuated Robotics, section 3.6. Both laws
come from the model alone: its Legendre energy, its inverse dynamics, and its linearisation at upright. Obstacles are
ignored.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import casadi as ca
import numpy as np

from repro.control.controller import Controller, ControllerOptions, ControlStep, MakeController, Samples
from repro.control.geometry import Disc
from repro.control.goal import Goal
from repro.control.predictive_model import PredictiveModel
from repro.mechanics.chain import Chain
from repro.mechanics.system import System
from repro.plugins.options import NotNegative, Positive

STATE_COST, FORCE_COST = (10.0, 10.0, 1.0, 1.0), 1.0  # of the LQR


@dataclass(frozen=True, kw_only=True)
class Options(ControllerOptions):
    """Options of the swing-up and of the regulator: what each is stands in conf/control/energy_shaping.yaml."""

    drives: ClassVar[str] = "a cart with one link by one force"

    energy_gain: Positive = 10.0
    position_gain: NotNegative = 4.0
    speed_gain: NotNegative = 3.0
    catch_angle: Positive = 0.4
    catch_rate: Positive = 3.0

    def fits(self, system: System) -> bool:
        """Whether it can drive a system."""
        return isinstance(system, Chain) and system.n_q == 2


@contextmanager
def build(options: Options, model: PredictiveModel, disc: Disc | None, samples: Samples) -> Iterator[MakeController]:
    """Makes controllers of a model."""
    laws = Laws(model)
    yield lambda weights, goal: EnergyShaping(laws, weights, goal, options)


@dataclass(frozen=True)
class Laws:
    """The functions of a model of a cart with one link that both laws are made of; x = [q, qd] (4,), weights (n,)."""

    model: PredictiveModel

    @cached_property
    def hamiltonian(self) -> ca.Function:
        """(x, weights) -> H = p qd - L in J: of all T and V with the same motions the same, but for a constant."""
        x, weights = self._symbols
        kinetic, potential = self.model.energy(x, weights)
        momentum = ca.gradient(kinetic - potential, x)[2:]
        return ca.Function("hamiltonian", [x, weights], [ca.dot(momentum, x[2:]) - kinetic + potential])

    @cached_property
    def linearised(self) -> ca.Function:
        """(x, weights) -> d(xd)/dx (4, 4) and d(xd)/df (4, 1), without force."""
        x, weights = self._symbols
        force = ca.MX.sym("f")
        rate = self.model.derivative(x, force, weights)
        slopes = ca.graph_substitute([ca.jacobian(rate, x), ca.jacobian(rate, force)], [force], [ca.MX(0.0)])
        return ca.Function("linearised", [x, weights], slopes)

    def regulator(self, x: np.ndarray, weights: np.ndarray, time_step: float) -> np.ndarray:
        """The gain (4,) of the regulator at a state of rest, see `lqr`."""
        of_state, of_force = self.linearised(x, weights)
        return lqr(np.asarray(of_state), np.asarray(of_force), time_step)

    def inverse(self, x: np.ndarray, qdd: tuple[float, float], weights: np.ndarray) -> np.ndarray:
        """The generalised force (2,) for an acceleration."""
        return np.asarray(self.model.inverse(x, qdd, 0.0, weights)).ravel()

    @property
    def _symbols(self) -> tuple[ca.MX, ca.MX]:
        return ca.MX.sym("x", 4), ca.MX.sym("w", self.model.model.n_parameters)


@dataclass
class EnergyShaping(Controller):
    """Swings up the link of a model with these weights (n,), and holds it at a goal."""

    laws: Laws
    weights: np.ndarray
    goal: Goal
    options: Options

    def __post_init__(self) -> None:
        upright = np.append(self.goal.q, np.zeros(2))
        self._feedback = self.laws.regulator(upright, self.weights, self.options.time_step)
        self._energy_up = float(self.laws.hamiltonian(upright, self.weights))
        (self._limit,) = self.options.limits(self.laws.model.system)

    def decide(self, state: np.ndarray) -> ControlStep:
        """The force at a state (4,)."""
        error = np.append(self.goal.error(state[:2]), state[2:])
        if abs(error[1]) < self.options.catch_angle and abs(error[3]) < self.options.catch_rate:
            force = -float(self._feedback @ error)
        else:
            force = self._swing(state, error)
        return ControlStep(np.clip([force], -self._limit, self._limit))

    def _swing(self, state: np.ndarray, error: np.ndarray) -> float:
        laws, weights, options = self.laws, self.weights, self.options
        of_link = np.array([state[0], state[1], 0.0, state[3]])
        energy = float(laws.hamiltonian(of_link, weights)) - self._energy_up
        coupling, inertia = laws.inverse(state, (0.0, 1.0), weights) - laws.inverse(state, (0.0, 0.0), weights)
        # the cart's acceleration does the work -M_12 xdd thd on the link
        pumping = options.energy_gain * energy * np.sign(coupling) * abs(np.cos(state[1])) * state[3]
        cart = pumping - options.position_gain * error[0] - options.speed_gain * error[2]
        turning = -laws.inverse(state, (cart, 0.0), weights)[1] / inertia
        return float(laws.inverse(state, (cart, turning), weights)[0])


def lqr(of_state: np.ndarray, of_force: np.ndarray, time_step: float) -> np.ndarray:
    """Gain (4,) of the linear-quadratic regulator of a linearised system, for a force held over each time step, s.

    Zero where there is none, as for a model with a singular mass matrix: its link is let go near upright.
    """
    from scipy.linalg import expm, solve_discrete_are

    generator = np.block([[of_state, of_force], [np.zeros((1, 5))]])
    if not np.all(np.isfinite(generator)):
        return np.zeros(4)
    held = expm(generator * time_step)
    a, b = held[:-1, :-1], held[:-1, -1:]
    try:
        value = solve_discrete_are(a, b, np.diag(STATE_COST), np.array([[FORCE_COST]]))
    except np.linalg.LinAlgError:
        return np.zeros(4)
    return np.asarray(np.linalg.solve(FORCE_COST + b.T @ value @ b, b.T @ value @ a)[0])
