"""Port-Hamiltonian systems as expressions, their interconnection, again such a system, and a chain of equal links."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi
import numpy as np

from repro.mechanics.system import System
from repro.models.model import Model


@dataclass(frozen=True)
class PortSystem:
    """Eq. (5): xdot = (J - R) dH/dx + g u, y = g' dH/dx.

    state: symbols (n_x,); energy: H(x) in J; interconnection J, resistance R: (n_x, n_x); ports g: (n_x, n_u). Matrices
    may be sparse, and may depend on x.
    """

    state: casadi.SX
    energy: casadi.SX
    interconnection: casadi.SX
    resistance: casadi.SX
    ports: casadi.SX

    @classmethod
    def storage(cls, state: casadi.SX, energy: casadi.SX) -> "PortSystem":
        """A store of energy whose state is what flows in at its ports: xdot = u, y = dH/dx."""
        n = state.numel()
        return cls(state, energy, casadi.SX(n, n), casadi.SX(n, n), casadi.SX.eye(n))

    @property
    def gradient(self) -> casadi.SX:
        """dH/dx."""
        return casadi.gradient(self.energy, self.state)

    @property
    def output(self) -> casadi.SX:
        """y, conjugate to u: y'u is the power that flows in."""
        return self.ports.T @ self.gradient

    def rate(self, inputs: casadi.SX | None = None) -> casadi.SX:
        """xdot under the inputs u (n_u,), 0 by default."""
        drift = (self.interconnection - self.resistance) @ self.gradient
        return drift if inputs is None else drift + self.ports @ inputs


def interconnect(
    systems: Sequence[PortSystem], skew: casadi.DM, resistive: casadi.SX | casadi.DM | None = None
) -> PortSystem:
    """Join all ports by u = (K - P) y + e, with e the inputs that are left: H is the sum of the parts' H.

    skew K (n_u, n_u) moves power between the ports without loss, as a Dirac structure does; resistive P >= 0 is a port
    to dissipation. Then J = diag(J_i) + G K G' is skew again, and R = diag(R_i) + G P G' positive semi-definite.
    ValueError for a K that is not skew-symmetric.
    """
    if any((skew + skew.T).nonzeros()):  # a norm of it would take memory for every entry, zeros too
        raise ValueError("the interconnection makes or loses power: its matrix is not skew-symmetric")
    ports = casadi.diagcat(*(system.ports for system in systems))
    interconnection = casadi.diagcat(*(system.interconnection for system in systems)) + ports @ skew @ ports.T
    resistance = casadi.diagcat(*(system.resistance for system in systems))
    if resistive is not None:
        resistance = resistance + ports @ resistive @ ports.T
    state = casadi.vertcat(*(system.state for system in systems))
    energy = sum((system.energy for system in systems), casadi.SX(0))
    return PortSystem(state, energy, interconnection, resistance, ports)


@dataclass(frozen=True)
class ChainLink:
    """One link: mass in kg, damping in N s/m, and the energy in J of its spring at an extension in m."""

    mass: float
    damping: float
    spring: Callable[[casadi.SX], casadi.SX]

    @classmethod
    def learned(cls, model: Model, weights: np.ndarray) -> "ChainLink":
        """The link that a model of one coordinate has learned; ValueError where mass or damping is not constant."""
        if model.n_q != 1:
            raise ValueError(f"a link has one coordinate, not {model.n_q}")
        fixed = casadi.SX(casadi.DM(weights))
        q, qd = casadi.SX.sym("q"), casadi.SX.sym("qd")
        mass = model.mass_matrix(q, qd, fixed)
        damping = casadi.jacobian(model.friction(q, qd, fixed), qd)
        return cls(
            _constant(mass, q, qd),
            _constant(damping, q, qd),
            lambda s: model.energies(s, casadi.SX(0), fixed).potential,
        )

    @classmethod
    def true(cls, system: System) -> "ChainLink":
        """The link that a system of one coordinate is."""
        q, qd = casadi.SX.sym("q"), casadi.SX.sym("qd")
        mass = casadi.hessian(casadi.SX(system.kinetic([q], [qd], casadi)), qd)[0]
        damping = casadi.hessian(casadi.SX(system.dissipation([q], [qd], casadi)), qd)[0]
        return cls(_constant(mass, q, qd), _constant(damping, q, qd), lambda s: system.potential([s], casadi))


def link_chain(link: ChainLink, links: int) -> PortSystem:
    """The link so many times, the first hanging on a wall; state [extensions s; momenta p], (2 links,).

    Every link gives its spring a store of V(s), its mass one of p^2 / (2 m), and its damper a port. The interconnection
    is the incidence matrix D of the chain: sdot = D v and f = -D' dV/ds, skew and sparse; the dampers see D v.
    """
    extension, momentum = casadi.SX.sym("s", links), casadi.SX.sym("p", links)
    springs = casadi.vertcat(*(link.spring(s) for s in casadi.vertsplit(extension)))
    stores = [
        PortSystem.storage(extension, casadi.sum1(springs)),
        PortSystem.storage(momentum, casadi.sumsqr(momentum) / (2 * link.mass)),
    ]
    incidence, nothing = _incidence(links), casadi.DM(links, links)
    skew = casadi.blockcat([[nothing, incidence], [-incidence.T, nothing]])
    return interconnect(stores, skew, casadi.diagcat(nothing, link.damping * (incidence.T @ incidence)))


def _incidence(links: int) -> casadi.DM:
    """D: the rate of each extension is the velocity of its own mass less that of the one before."""
    own = np.arange(links)
    rows, columns = np.concatenate([own, own[1:]]), np.concatenate([own, own[:-1]])
    signs = np.concatenate([np.ones(links), -np.ones(links - 1)])
    return casadi.DM.triplet(rows.tolist(), columns.tolist(), casadi.DM(signs), links, links)


def _constant(value: casadi.SX, *of: casadi.SX) -> float:
    if casadi.depends_on(value, casadi.vertcat(*of)):
        raise ValueError("the mass and the damping of a link must be constant")
    return float(casadi.evalf(value))
