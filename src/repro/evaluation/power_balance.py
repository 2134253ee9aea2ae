"""The power balance of a motion: supplied by the inputs, stored as energy, dissipated."""

import numpy as np


def supplied_power(q: np.ndarray, tau: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Mean power that the generalised forces supply over each step, (..., samples - 1) in W.

    q (..., samples, n_q) in m and rad, tau (..., samples, n_q) in N and N m, held over the step after its sample,
    time (samples,) in s. Since tau is held, sum_i tau_i (change of q_i) is the exact work, whatever the motion between.
    """
    work = np.sum(tau[..., :-1, :] * np.diff(q, axis=-2), axis=-1)
    return np.asarray(work / np.diff(time))


def power_balance(q: np.ndarray, tau: np.ndarray, energy: np.ndarray, time: np.ndarray) -> dict[str, np.ndarray]:
    """Mean powers over the step after each sample, (samples,) in W, zero at the last: supplied, dH/dt and dissipated.

    q and tau (samples, n_q) as for `supplied_power`, energy (samples,) in J, time (samples,) in s.
    """
    supplied = np.append(supplied_power(q, tau, time), 0.0)
    stored = np.append(np.diff(energy) / np.diff(time), 0.0)
    return {"supplied": supplied, "dH/dt": stored, "dissipated": supplied - stored}
