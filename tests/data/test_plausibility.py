"""What contradicts itself in a recording is found, and a sound recording passes."""

import math

import numpy as np
import pytest

from repro.data.plausibility import agreement, contradictions, remarks
from repro.data.recorded_rows import RecordedRows
from repro.mechanics.coordinate import Coordinate

COORDINATES = (Coordinate("x", "m", is_angle=False), Coordinate("theta", "rad", is_angle=True))
TIME = 0.02 * np.arange(500)
EPISODE = np.repeat([0, 1], 250)
ROW = np.arange(500)
RATES = np.array([2.0, 5.0, 11.0])


def motion(order: int) -> np.ndarray:
    """The derivative of this order of two sums of sines, (sample, 2)."""
    phases = TIME[:, None] * RATES + order * math.pi / 2
    return np.stack([np.sin(phases) @ (RATES**order * each) for each in ([0.3, 0.1, 0], [0.5, 0.4, 0.1])], axis=1)


Q, QD, QDD = map(motion, range(3))


def found(q=Q, qd=QD, qdd=QDD, time=TIME, kind="contradictions") -> str:
    rows = RecordedRows(q, 0 * q, time, EPISODE, EPISODE.astype(str), ROW, ROW < 0, qd, qdd)
    return " | ".join({"remarks": remarks, "contradictions": contradictions}[kind](rows, COORDINATES))


def changed(values: np.ndarray, column: int, change) -> np.ndarray:
    values = values.copy()
    values[:, column] = change(values[:, column])
    return values


def jump(values: np.ndarray) -> np.ndarray:
    return values + np.where(np.arange(500) == 250, 1e6, 0.0)


@pytest.mark.parametrize("kind", ["contradictions", "remarks"])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_sound_recording_passes(kind: str, noise: float) -> None:
    rng = np.random.default_rng(0)
    noisy = [values + noise * rng.standard_normal(values.shape) for values in (Q, QD, QDD)]
    assert found(*noisy, kind=kind) == ""
    assert found(noisy[0], None, None, kind=kind) == ""


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"q": changed(Q, 1, np.degrees)}, r"theta changes 57.3 times .* is the position in degrees"),
        ({"qd": changed(QD, 1, np.degrees)}, "is the position in rad and the velocity in deg/s"),
        ({"qd": changed(QD, 1, lambda v: v * 60 / (2 * math.pi))}, "is the velocity in rpm"),
        ({"time": 1000 * TIME}, r"x changes 0.001 times .*data.units.time=\[ms\]"),
        ({"q": changed(Q, 0, lambda v: 1000 * v)}, "is the position in mm"),
        ({"qd": -QD}, "x changes -1 times .* a sign or a unit"),
        ({"q": QD, "qd": Q, "qdd": None}, "the velocity of x does not belong to it"),
        ({"qd": changed(QD, 1, lambda v: 0 * v)}, "the velocity of theta does not belong to it"),
        ({"qd": changed(QD, 1, lambda v: 0 * v + 0.1)}, "the velocity of theta does not belong to it"),
        ({"qdd": changed(QDD, 1, np.degrees)}, "the velocity of theta changes 0.0175 times as much as the acceler"),
        ({"q": Q[:, [0, 0]]}, "x and theta have the same values"),
        ({"qdd": changed(QDD, 0, jump)}, r"xdd is 1e\+06 in data row 251"),
    ],
)
def test_a_contradiction_is_named(changes: dict, message: str) -> None:
    import re

    assert re.search(message, found(**changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time": 100 * TIME, "qd": QD / 100}, "the sampling interval is 2 s"),
        ({"q": changed(Q, 1, np.degrees), "qd": changed(QD, 1, np.degrees)}, "turns: is it in degrees"),
        ({"q": changed(Q, 0, lambda v: 0 * v), "qd": changed(QD, 0, lambda v: 0 * v)}, "x never changes"),
        ({"qd": changed(QD, 1, lambda v: 1.4 * v)}, "the velocity of theta fits it only roughly"),
        ({"q": changed(Q, 1, lambda v: v + np.where(ROW > 120, 0.7, 0.0))}, "disagree from data row 12"),
    ],
)
def test_a_suspicion_is_named(changes: dict, message: str) -> None:
    assert message in found(**changes, kind="remarks")
    assert found(**({"qdd": None} | changes)) == ""


def test_agreement_measures_the_ratio_and_crosses_no_restart() -> None:
    shifted = Q[:, 0] + 5.0 * EPISODE  # a jump at the restart is none of the velocity's
    same = agreement(shifted, QD[:, 0], TIME, EPISODE)
    assert same is not None
    assert same.ratio == pytest.approx(1.0, abs=1e-3)
    assert same.unexplained < 1e-6
    assert agreement(np.ones(500), np.zeros(500), TIME, EPISODE) is None
