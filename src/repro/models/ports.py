"""Port-Hamiltonian systems as expressions, and their interconnection: again a port-Hamiltonian system."""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi


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
    if casadi.norm_inf(casadi.vec(skew + skew.T)) > 0:
        raise ValueError("the interconnection makes or loses power: its matrix is not skew-symmetric")
    ports = casadi.diagcat(*(system.ports for system in systems))
    interconnection = casadi.diagcat(*(system.interconnection for system in systems)) + ports @ skew @ ports.T
    resistance = casadi.diagcat(*(system.resistance for system in systems))
    if resistive is not None:
        resistance = resistance + ports @ resistive @ ports.T
    state = casadi.vertcat(*(system.state for system in systems))
    energy = casadi.SX(0)
    for system in systems:
        energy = energy + system.energy
    return PortSystem(state, energy, interconnection, resistance, ports)
