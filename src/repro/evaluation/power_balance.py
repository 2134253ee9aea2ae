"""The power balance of a motion: supplied by the inputs, stored as energy, dissipated."""

import numpy as np

from repro.mechanics.inputs import input_matrix
from repro.mechanics.system import System


def supplied_power(system: System, states: np.ndarray, u: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Mean power that the inputs supply over each step, (..., samples - 1) in W: sum_i u_i (B'qd)_i.

    states (..., samples, 2 n_q) and u (..., samples, n_u), held over the step after its sample; time (samples,) in s.
    Simpson's rule on the cubic through both ends of a step: exact for a constant B, of fourth order otherwise.
    """
    q, qd = states[..., : system.n_q], states[..., system.n_q :]
    length = np.diff(time)[:, None]
    start, end = (q[..., :-1, :], qd[..., :-1, :]), (q[..., 1:, :], qd[..., 1:, :])
    middle = (start[0] + end[0]) / 2 + length * (start[1] - end[1]) / 8
    middle_rate = 1.5 * (end[0] - start[0]) / length - (start[1] + end[1]) / 4
    supplied = np.zeros(())
    for share, (at, rate) in zip((1 / 6, 4 / 6, 1 / 6), (start, (middle, middle_rate), end), strict=True):
        velocities = np.einsum("...qu,...q->...u", input_matrix(system, at), rate)
        supplied = supplied + share * np.sum(u[..., :-1, :] * velocities, axis=-1)
    return supplied


def power_balance(
    system: System, states: np.ndarray, u: np.ndarray, energy: np.ndarray, time: np.ndarray
) -> dict[str, np.ndarray]:
    """Mean powers over the step after each sample, (samples,) in W, zero at the last: supplied, dH/dt and dissipated.

    states (samples, 2 n_q) and u (samples, n_u) as for `supplied_power`, energy (samples,) in J, time (samples,) in s.
    """
    supplied = np.append(supplied_power(system, states, u, time), 0.0)
    stored = np.append(np.diff(energy) / np.diff(time), 0.0)
    return {"supplied": supplied, "dH/dt": stored, "dissipated": supplied - stored}
