import numpy as np
import pytest

from repro.data.dataset import Measurement
from repro.data.smooth import PRIOR, _Filter, _motions, smooth

TIMES = np.array([0.0, 0.1, 0.17, 0.3, 0.42])


def _dense(values: np.ndarray, times: np.ndarray, variance: float, intensity: float) -> np.ndarray:
    """Mean of all states (sample, 3) given the positions that are there, from the joint Gaussian itself."""
    n = len(times)
    joint, mean = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    covariance, state = np.diag(PRIOR), np.array([values[np.isfinite(values)][0], 0, 0])
    for k in range(n):
        block = slice(3 * k, 3 * k + 3)
        mean[block], joint[block, block] = state, covariance
        if k + 1 < n:
            transition, noise = (each[0] for each in _motions(np.diff(times)[None])[k])
            joint[3 * k + 3 : 3 * k + 6, : 3 * k + 3] = transition @ joint[block, : 3 * k + 3]
            joint[: 3 * k + 3, 3 * k + 3 : 3 * k + 6] = joint[3 * k + 3 : 3 * k + 6, : 3 * k + 3].T
            state, covariance = transition @ state, transition @ covariance @ transition.T + intensity * noise
    seen = np.flatnonzero(np.isfinite(values))
    cross = joint[:, 3 * seen]
    gain = np.linalg.solve(cross[3 * seen] + variance * np.eye(len(seen)), (values[seen] - mean[3 * seen]))
    return (mean + cross @ gain).reshape(n, 3)


@pytest.mark.parametrize("missing", [[], [2], [0, 3]])
def test_the_smoother_is_the_gaussian_conditional(missing: list[int]) -> None:
    values = np.sin(3 * TIMES)
    values[missing] = np.nan
    motions = _motions(np.append(np.diff(TIMES), 1.0)[None])
    position = values[None, :, None]
    filtered = _Filter(position, np.full_like(position, np.nan), motions, np.full((2, 1), 1e-2), np.array([30.0]))
    np.testing.assert_allclose(filtered.smoothed()[0, :, 0], _dense(values, TIMES, 1e-2, 30.0), atol=1e-6)


def test_unknown_noise_is_found_and_motion_is_recovered() -> None:
    time, draw = np.arange(400) * 0.01, np.random.default_rng(0)
    q, qd = np.sin(5 * time)[None, :, None], 5 * np.cos(5 * time)[None, :, None]
    recorded = Measurement(q + 2e-3 * draw.standard_normal(q.shape), qd + 0.05 * draw.standard_normal(q.shape))
    *motion, found = smooth(recorded, time, np.zeros(400, dtype=int))
    assert found.q_noise is not None and found.qd_noise is not None
    assert found.q_noise[0] == pytest.approx(2e-3, rel=0.2)
    assert found.qd_noise[0] == pytest.approx(0.05, rel=0.2)
    exact = q, qd, -25 * q
    for ours, true, most in zip(motion, exact, (5e-4, 0.02, 1.0), strict=True):  # of amplitudes 1, 5 and 25
        assert np.abs(ours - true).mean() < most


def test_episodes_are_smoothed_apart() -> None:
    time, episode = np.arange(60) * 0.02, np.arange(60) // 20
    q = np.cos(time)[None, :, None] + 3.0 * episode[None, :, None]
    noise = np.array([1e-3])
    whole, *_ = smooth(Measurement(q, q_noise=noise), time, episode)
    shifted, *_ = smooth(Measurement(q - 3.0 * episode[None, :, None], q_noise=noise), time, episode)
    np.testing.assert_allclose(whole - 3.0 * episode[:, None], shifted, atol=1e-9)
