"""A chain of equal links, each a mass on a spring and a damper."""

from collections.abc import Callable
from dataclasses import dataclass

import casadi
import numpy as np

from repro.mechanics.system import System
from repro.models.model import Model
from repro.models.ports import PortSystem, interconnect


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
        mass = casadi.jacobian(model.momentum(q, qd, fixed), qd)
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
