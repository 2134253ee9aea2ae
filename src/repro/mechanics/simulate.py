"""Fixed-step simulation under a force that is held over each step."""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from repro.mechanics.compile import compiled
from repro.mechanics.substeps import SubstepRule


def simulate(
    acceleration: ca.Function,
    initial: np.ndarray,
    tau: np.ndarray,
    time_step: float,
    *,
    substeps: int | None = None,
    angles: Sequence[int] | None = None,
    parameters: np.ndarray | None = None,
    engine: str = "auto",
) -> np.ndarray:
    """Integrate qdd = acceleration(q, qd, tau, parameters) by classical RK4, tau held over each step of time_step s.

    initial: (batch, 2 n_q) = [q, qd]; tau: (batch, steps, n_q); parameters: (n_p,), or (batch, n_p) for one set each.
    Returns states (batch, steps + 1, 2 n_q); row k is the state at the start of step k.
    Without `substeps` each step has as many as the speed of `angles` (positions of coordinates; all by default) asks
    for, see `SubstepRule`. A trajectory that is no longer finite, or too fast to be followed, is NaN from there on.
    ValueError for shapes that do not fit, UserError for an engine that is unknown or not there.
    """
    n_q = acceleration.numel_out(0)
    initial, tau = np.asarray(initial, dtype=float), np.ascontiguousarray(tau, dtype=float)
    if tau.ndim != 3 or initial.shape != (len(tau), 2 * n_q) or tau.shape[2] != n_q:
        raise ValueError(f"initial (batch, {2 * n_q}) and tau (batch, steps, {n_q}) got {initial.shape}, {tau.shape}")
    weights = np.ascontiguousarray(np.atleast_2d(np.zeros(0) if parameters is None else parameters), dtype=float)
    if weights.shape[1] != acceleration.numel_in(3) or len(weights) not in {1, len(tau)}:
        raise ValueError(f"parameters ({acceleration.numel_in(3)},), one set or one a trajectory, got {weights.shape}")
    if substeps is not None and substeps < 1:
        raise ValueError(f"substeps must be at least 1, got {substeps}")
    states = np.empty((len(tau), tau.shape[1] + 1, 2 * n_q))
    states[:, 0] = initial
    everywhere = range(n_q) if angles is None else angles
    rule = SubstepRule.for_angles(time_step, everywhere) if substeps is None else SubstepRule.fixed(time_step, substeps)
    compiled(acceleration, engine)(rule, tau, weights, states)
    return states
