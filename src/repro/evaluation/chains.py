"""A learned link, joined to itself many times over: state and energy against the true chain, cost, and a monolith."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.evaluation.pointwise import MetricValues
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.system import System
from repro.models.model import Model
from repro.models.ports import ChainLink, PortSystem, link_chain

SECONDS, TIME_STEP = 10.0, 0.004
KEPT = 25  # steps from one kept state to the next
REACH = 0.3  # m and kg m/s, of the random start


@dataclass(frozen=True)
class Motion:
    """Every KEPT-th state (time, 2 links) = [extensions; momenta], their energies (time,) in J; processor time in s."""

    states: np.ndarray
    energy: np.ndarray
    seconds: float


def chain_errors(model: Model, parameters: np.ndarray, system: System, links: Sequence[int]) -> Iterator[MetricValues]:
    """For each number of links: relative errors of state and energy after 10 s, and seconds.

    The true chain is of the same structure and simulated with the same steps. Seconds: of one member, built and run.
    """
    learned = [ChainLink.learned(model, weights) for weights in np.asarray(parameters, dtype=float)]
    for number in links:
        start = random_start(number)
        plant = simulate_chain(ChainLink.true(system), start)
        motions = [simulate_chain(link, start) for link in learned]
        gap = np.array([np.linalg.norm(m.states[-1] - plant.states[-1]) for m in motions])
        energy = np.array([abs(m.energy[-1] - plant.energy[-1]) for m in motions])
        yield MetricValues("test", f"chain_error_{number}", gap / np.linalg.norm(plant.states[-1]), "1")
        yield MetricValues("test", f"chain_energy_error_{number}", energy / plant.energy[0], "1")
        yield MetricValues("test", f"chain_seconds_{number}", np.array([m.seconds for m in motions]), "s")


def simulate_chain(link: ChainLink, start: np.ndarray) -> Motion:
    """Build the chain and follow it for 10 s by RK4, at a cost that is linear in its length; start: (2 links,)."""
    begun = time.process_time()
    chain = link_chain(link, len(start) // 2)
    rate, energy = _rate(chain), casadi.Function("energy", [chain.state], [chain.energy])
    x, kept = start, [start]
    for step in range(1, round(SECONDS / TIME_STEP) + 1):
        x = rk4_step(rate, x, TIME_STEP)
        if step % KEPT == 0:
            kept.append(x)
    took = time.process_time() - begun
    energies = np.array([evaluate(energy, state)[0] for state in kept])
    return Motion(np.stack(kept), energies, took)


def random_start(links: int) -> np.ndarray:
    """Extensions and momenta, the same for every model, (2 links,)."""
    return np.random.default_rng(7).uniform(-REACH, REACH, 2 * links)


def _rate(chain: PortSystem) -> Callable[[np.ndarray], np.ndarray]:
    """xdot = (J - R) dH/dx with the constant J - R of a chain as a sparse matrix."""
    from scipy.sparse import csr_matrix

    structure = casadi.evalf(chain.interconnection - chain.resistance)
    rows, columns = structure.sparsity().get_triplet()
    sparse = csr_matrix((structure.nonzeros(), (rows, columns)), shape=structure.shape)
    gradient = casadi.Function("gradient", [chain.state], [casadi.densify(chain.gradient)])
    buffer: Any
    buffer, run = gradient.buffer()
    slope = np.empty(chain.state.numel())
    buffer.set_res(0, slope.data)

    def rate(x: np.ndarray) -> np.ndarray:
        buffer.set_arg(0, x.data)
        run()
        return np.asarray(sparse @ slope)

    return rate
