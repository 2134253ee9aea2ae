"""Feature maps and their jets: everything a Lagrangian model needs to know of its inputs, computed once per dataset."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import euler_lagrange
from repro.models.products import Features, Maths, Scalars

FeatureText = Callable[[Scalars, Scalars, Maths], Features]


@dataclass(frozen=True)
class FeatureMap:
    """Features z(q, qd), written once as `text(q, qd, m) -> {name: scalar}` for any maths namespace m.

    A model L = N(z(q, qd)) needs no derivative of z during training: with u_c = dz/dqd_c and
    w_c = d/dt(dz/dqd_c) - dz/dq_c,

        p_c   = DN[u_c]
        tau_c = D^2 N[u_c, zdot] + DN[w_c]          the Euler-Lagrange residual (2), no Hessian formed
        M_cd  = D^2 N[u_c, u_d] + DN[v_cd],  v_cd = d^2 z / dqd_c dqd_d
    """

    text: FeatureText
    n_q: int

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the features, in order."""
        q, qd, _ = self._symbols()
        return tuple(self.text(casadi.vertsplit(q), casadi.vertsplit(qd), casadi))

    def __len__(self) -> int:
        return len(self.names)

    @property
    def mass_pairs(self) -> tuple[tuple[int, int], ...]:
        """Index pairs (c, d), c <= d, of the entries of a symmetric mass matrix."""
        return tuple((c, d) for c in range(self.n_q) for d in range(c, self.n_q))

    def expression(self, q: casadi.SX, qd: casadi.SX) -> casadi.SX:
        """The features as a CasADi column (n_z,)."""
        return casadi.vcat(
            [casadi.SX(z) for z in self.text(casadi.vertsplit(q), casadi.vertsplit(qd), casadi).values()]
        )

    def jets(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Rows [z, zdot, u_1.., w_1.., v_11, ..] (..., 2 + 2 n_q + n_q (n_q + 1) / 2, n_z) at q, qd, qdd (..., n_q)."""
        columns = evaluate(self._jet_function, q, qd, qdd).reshape(*q.shape[:-1], len(self), -1)
        return np.ascontiguousarray(columns.swapaxes(-1, -2))

    def potential_rows(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Of these jets [z, w_1, ..] alone, what V = beta . z needs: (..., 1 + n_q, n_z)."""
        if not len(self):
            return np.zeros((*q.shape[:-1], 1 + self.n_q, 0))
        return self.jets(q, qd, qdd)[..., [0, *range(2 + self.n_q, 2 + 2 * self.n_q)], :]

    @cached_property
    def _jet_function(self) -> casadi.Function:
        q, qd, qdd = self._symbols()
        z = self.expression(q, qd)
        zdot = casadi.jtimes(z, q, qd) + casadi.jtimes(z, qd, qdd)
        u = casadi.jacobian(z, qd)
        w = euler_lagrange(z, q, qd, qdd)
        v = [casadi.jacobian(u[:, c], qd)[:, d].T for c, d in self.mass_pairs]
        rows = casadi.vertcat(z.T, zdot.T, u.T, w, *v)
        # by columns, as `evaluate` lays its results out: no copy of a large array then
        return casadi.Function("jets", [q, qd, qdd], [casadi.densify(rows.T)])

    def _symbols(self) -> tuple[casadi.SX, casadi.SX, casadi.SX]:
        q, qd, qdd = (casadi.SX.sym(name, self.n_q) for name in ("q", "qd", "qdd"))
        return q, qd, qdd
