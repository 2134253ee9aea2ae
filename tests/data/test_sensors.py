from pathlib import Path

import numpy as np
import pytest
from simulated import random_force

from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.mechanics.system import load

SMALL = {"seeds": [0, 1], "samples": 200, "episode_steps": 50, "reset": "random"}
SYSTEM = load("sip")


@pytest.mark.parametrize("labels", ["differenced", "savitzky_golay", "smoothed"])
@pytest.mark.parametrize("measured", ["states", "positions"])
def test_sensors_touch_the_training_part_alone(measured: str, labels: str) -> None:
    exact = random_force(SYSTEM, **SMALL)
    data = random_force(SYSTEM, **SMALL, measured=measured, labels=labels, q_noise=1e-4, qd_noise=1e-3, force_noise=0.1)
    for name in ("q", "qd", "qdd", "tau"):
        np.testing.assert_array_equal(getattr(data.test, name), getattr(exact.test, name))
        assert np.abs(getattr(data.train, name) - getattr(exact.train, name)).max() > 0
    assert np.all(data.tau[..., 1] == 0)
    recorded = data.train.measurement
    assert recorded is not None
    assert (recorded.qd is None) == (measured == "positions")
    assert recorded.tau_noise == pytest.approx([0.1, 0.0])
    errors = [np.abs(estimate - exact.train.q).mean() for estimate in (data.train.q, recorded.q)]
    assert errors[0] < 10 * errors[1]


def test_a_force_is_held_over_its_samples() -> None:
    fine = random_force(SYSTEM, **SMALL, sample_step=0.01)
    coarse = random_force(SYSTEM, **SMALL | {"samples": 52, "episode_steps": 13})
    assert fine.time_step == pytest.approx(0.01)
    holds = fine.tau[:, :48, 0].reshape(2, 12, 4)
    assert np.all(holds == holds[..., :1])
    np.testing.assert_array_equal(holds[..., 0], coarse.tau[:, :12, 0])
    np.testing.assert_allclose(fine.q[:, :48:4], coarse.q[:, :12], atol=1e-5)


def test_encoders_round_shift_and_wrap() -> None:
    exact = random_force(SYSTEM, **SMALL)
    zero, step = 0.02, 2 * np.pi / 4096
    data = random_force(
        SYSTEM, **SMALL, measured="positions", labels="smoothed", quantisation=[1e-4, step], encoder_zero=zero,
        wrapped=True,
    )  # fmt: skip
    recorded = data.train.measurement
    assert recorded is not None
    turns = (recorded.q[..., 1] - exact.train.q[..., 1] - zero) / (2 * np.pi)
    assert np.abs(turns - np.round(turns)).max() < step
    assert np.abs(np.diff(recorded.q[..., 1], axis=1)[:, :49]).max() < 2
    np.testing.assert_allclose(recorded.q[..., 0], np.round(recorded.q[..., 0], 4), atol=1e-12)
    assert recorded.q_noise == pytest.approx(np.array([1e-4, step]) / 12**0.5)


def test_what_sensors_recorded_is_stored(tmp_path: Path) -> None:
    data = random_force(SYSTEM, **SMALL, measured="positions", labels="smoothed", q_noise=1e-3)
    data.save(tmp_path)
    loaded = Dataset.load(tmp_path)
    assert data.measurement is not None
    assert loaded.measurement is not None
    np.testing.assert_array_equal(loaded.measurement.q, data.measurement.q)
    assert loaded.measurement.qd is None


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"measured": "positions"}, "labels"),
        ({"sample_step": 0.03}, "sample_step"),
        ({"quantisation": [0.1]}, "quantisation"),
        ({"measured": "forces"}, "measured"),
    ],
)
def test_impossible_sensors_are_named(change: dict[str, object], word: str) -> None:
    with pytest.raises(UserError, match=word):
        random_force(SYSTEM, **SMALL, **change)  # type: ignore[arg-type]
