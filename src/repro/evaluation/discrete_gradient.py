"""A structure-preserving integrator of port-Hamiltonian systems: the midpoint discrete gradient."""

import ctypes
from dataclasses import dataclass

import casadi
import numpy as np

from repro.codegen import straight_line
from repro.codegen.array_evaluation import evaluate
from repro.codegen.c_library import has_compiler, load_library
from repro.codegen.c_source import c_source
from repro.mechanics.derive import solve_symmetric
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.model import Model

INPUTS = ("x", "guess", "parameters", "h")  # of a step
TOLERANCE = 1e-13  # of a step, relative to the state
MOST = 200  # iterations of a step
COMPILED_FROM = 100_000  # steps of all trajectories; for fewer, compiling takes longer than it saves
# Below this |d|^2 the correction of the mean slope, of order |d|^2, is smaller than what rounding makes of it, and the
# iteration would not settle; without it such a step errs by |d|^3, 3e-14 at most.
LEAST_MOVE = 1e-9


class NotQuadraticError(ValueError):
    """T or the Rayleigh function is not quadratic in the velocities, so that x = [q; p] has no closed form."""


@dataclass(frozen=True)
class PhaseSpace:
    """A system xdot = S(x) dH/dx in x = [q; p] without input; functions of columns x, x' (2 n_q,) and parameters.

    energy -> H; to_phase: [q; qd] -> x; to_rates: x -> [q; qd]; step: (x, guess of the next x, parameters, h) -> a
    better guess.
    """

    energy: casadi.Function
    to_phase: casadi.Function
    to_rates: casadi.Function
    step: casadi.Function


def phase_space(model: Model) -> PhaseSpace:
    """The phase space of a model with a quadratic T; J and R are canonical unless the model has its own.

    NotQuadraticError for other models.

    The step is that of Gonzalez (1996): x' = x + h S(x_m) G, with x_m the midpoint and d = x' - x,

        G = dH(x_m) + (H(x') - H(x) - dH(x_m) . d) / |d|^2 d,    so that G . d = H(x') - H(x) exactly.

    With S = J - R the energy of the step is H(x') - H(x) = -h G' R G, whatever h: it never rises, and J alone keeps it.
    """
    n = model.n_q
    x, guess, h = casadi.SX.sym("x", 2 * n), casadi.SX.sym("guess", 2 * n), casadi.SX.sym("h")
    parameters = casadi.SX.sym("parameters", model.n_parameters)
    velocity, at_rest = _velocity(model, x, parameters), model.energies(x[:n], casadi.SX.zeros(n), parameters)
    total = 0.5 * casadi.dot(x[n:], velocity) + at_rest.potential
    energy = casadi.Function("energy", [x, parameters], [total], {"cse": True})
    middle, move = (x + guess) / 2, guess - x
    at_middle = casadi.SX.sym("middle", 2 * n)
    slope = casadi.Function(
        "slope", [at_middle, parameters], [casadi.gradient(energy(at_middle, parameters), at_middle)], {"cse": True}
    )(middle, parameters)
    gap = energy(guess, parameters) - energy(x, parameters) - casadi.dot(slope, move)
    size = casadi.sumsqr(move)
    mean_slope = slope + casadi.if_else(size > LEAST_MOVE, gap / (size + 1e-300), 0.0) * move
    following = x + h * (_structure(model, middle, parameters) @ mean_slope)
    q, qd = casadi.SX.sym("q", n), casadi.SX.sym("qd", n)
    phase = casadi.vertcat(q, model.momentum(q, qd, parameters))
    rates = casadi.vertcat(x[:n], velocity)
    return PhaseSpace(
        energy,
        casadi.Function("to_phase", [casadi.vertcat(q, qd), parameters], [casadi.densify(phase)]),
        casadi.Function("to_rates", [x, parameters], [casadi.densify(rates)]),
        casadi.Function("step", [x, guess, parameters, h], [casadi.densify(following)], {"cse": True}),
    )


def integrate(
    space: PhaseSpace, initial: np.ndarray, steps: int, time_step: float, parameters: np.ndarray
) -> np.ndarray:
    """States (batch, steps + 1, 2 n_q) from initial (batch, 2 n_q), both [q; p]; parameters (batch, n_parameters).

    Each step is solved by fixed-point iteration, until it changes by less than TOLERANCE of the state; a trajectory
    where MOST iterations do not reach that is NaN from there on.
    """
    states = np.empty((len(initial), steps + 1, initial.shape[1]))
    states[:, 0] = initial
    if len(initial) * steps >= COMPILED_FROM and has_compiler():
        _compile_and_run(space.step, states, time_step, parameters)
    else:
        _interpret(space.step, states, time_step, parameters)
    return states


def _compile_and_run(step: casadi.Function, states: np.ndarray, time_step: float, parameters: np.ndarray) -> None:
    """Fill states[:, 1:] (batch, steps + 1, n_x) from states[:, 0]; CompilerError without a compiler."""
    lines, n_work = straight_line.statements(step, INPUTS, "better")
    better_guess = straight_line.function("better_guess", INPUTS, "better", lines, n_work)
    sizes = f"#define N_X {step.numel_out(0)}\n"
    source = f"{straight_line.preamble()}\n{sizes}{better_guess}{c_source(__file__, 'fixed_point')}"
    run = load_library(source, straight_line.flags(lines)).integrate
    whole, real, array = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
    run.argtypes, run.restype = [whole, whole, real, real, whole, array, whole, array], None
    weights = np.ascontiguousarray(parameters, dtype=float)
    batch, points, _ = states.shape
    data, n_parameters = weights.ctypes.data, weights.shape[1]
    run(batch, points - 1, time_step, TOLERANCE, MOST, data, n_parameters, states.ctypes.data)


def _interpret(step: casadi.Function, states: np.ndarray, time_step: float, parameters: np.ndarray) -> None:
    move = np.zeros_like(states[:, 0])
    for k in range(states.shape[1] - 1):
        x = states[:, k]
        states[:, k + 1] = _solve(step, x, x + move, parameters, np.array([time_step]))
        move = np.nan_to_num(states[:, k + 1] - x)


def _solve(
    step: casadi.Function, x: np.ndarray, guess: np.ndarray, parameters: np.ndarray, h: np.ndarray
) -> np.ndarray:
    for _ in range(MOST):
        better = evaluate(step, x, guess, parameters, h)
        change = np.abs(better - guess).max(axis=1) / (1 + np.abs(x).max(axis=1))
        guess = better
        if not (change > TOLERANCE).any():  # one that is not finite moves no further
            break
    return np.where((change <= TOLERANCE)[:, None], guess, np.nan)


def _velocity(model: Model, x: casadi.SX, parameters: casadi.SX) -> casadi.SX:
    q, qd = x[: model.n_q], casadi.SX.sym("qd", model.n_q)
    mass = casadi.jacobian(model.momentum(q, qd, parameters), qd)
    if casadi.depends_on(mass, qd):
        raise NotQuadraticError(f"T of {type(model).__name__} is not quadratic in qd")
    return solve_symmetric(mass, x[model.n_q :])


def _structure(model: Model, x: casadi.SX, parameters: casadi.SX) -> casadi.SX:
    q, qd = x[: model.n_q], _velocity(model, x, parameters)
    if isinstance(model, PortHamiltonian):
        return model.structure_matrix(q, qd, parameters)
    zero, identity = casadi.SX(model.n_q, model.n_q), casadi.SX.eye(model.n_q)
    rate = casadi.SX.sym("rate", model.n_q)
    damping = casadi.jacobian(model.friction(q, rate, parameters), rate)
    if casadi.depends_on(damping, rate):
        raise NotQuadraticError(f"the friction of {type(model).__name__} is not linear in qd")
    return casadi.vertcat(casadi.horzcat(zero, identity), casadi.horzcat(-identity, -damping))
