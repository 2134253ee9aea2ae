"""Jets of features against finite differences of the features themselves."""

import numpy as np
import pytest

from repro.models.bases import engineered, library, raw, t1, t2
from repro.models.features import FeatureMap
from repro.models.position import cart_with_links

STEP = 1e-4
BASES = {"raw": raw, "engineered": engineered, "t1": t1, "t2": t2, "library": library}

TEXTS = {f"{name} {part}": getattr(basis, part) for name, basis in BASES.items() for part in ("kinetic", "potential")}
TEXTS |= {"position inertia": cart_with_links(2).inertia, "position potential": cart_with_links(2).potential}


@pytest.fixture(params=[name for name, text in TEXTS.items() if text(np.ones(2), np.ones(2), np)])
def text(request):
    return TEXTS[request.param]


@pytest.fixture
def motion():
    random = np.random.default_rng(3)
    return tuple(scale * random.normal(size=(5, 2)) for scale in (1.0, 1.5, 2.0))


def _values(text, q, qd):
    columns = text(np.moveaxis(q, -1, 0), np.moveaxis(qd, -1, 0), np).values()
    return np.stack([np.broadcast_to(column, q.shape[:-1]) for column in columns], axis=-1)


def _slope(function, direction_of):
    """Central difference of function(s) at 0, fourth order."""
    f = {k: function(k * direction_of) for k in (-2, -1, 1, 2)}
    return (8 * (f[1] - f[-1]) - (f[2] - f[-2])) / (12 * direction_of)


def _close(ours, expected):
    np.testing.assert_allclose(ours, expected, rtol=1e-6, atol=1e-6 * max(1.0, np.abs(expected).max()))


def test_value_and_rate_along_the_motion(text, motion):
    q, qd, qdd = motion
    jets = FeatureMap(text, 2).jets(q, qd, qdd)
    np.testing.assert_allclose(jets[:, 0], _values(text, q, qd), rtol=1e-14, atol=1e-14)
    _close(jets[:, 1], _slope(lambda s: _values(text, q + s * qd + s**2 / 2 * qdd, qd + s * qdd), STEP))


def test_momentum_rows_and_mass_rows_are_derivatives_by_velocities(text, motion):
    q, qd, qdd = motion
    features = FeatureMap(text, 2)
    jets = features.jets(q, qd, qdd)
    for c, axis in enumerate(np.eye(2)):
        _close(jets[:, 2 + c], _slope(lambda s, axis=axis: _values(text, q, qd + s * axis), STEP))
    for number, (c, d) in enumerate(features.mass_pairs):
        own, other = np.eye(2)[[c, d]]
        second = _slope(
            lambda s, own=own, other=other: _slope(lambda r: _values(text, q, qd + r * own + s * other), 1e-3), 1e-3
        )
        _close(jets[:, 6 + number], second)


def test_euler_lagrange_rows(text, motion):
    """w_c = d/dt (dz/dqd_c) - dz/dq_c."""
    q, qd, qdd = motion
    jets = FeatureMap(text, 2).jets(q, qd, qdd)
    for c, axis in enumerate(np.eye(2)):

        def momentum(s, axis=axis):
            place, rate = q + s * qd + s**2 / 2 * qdd, qd + s * qdd
            return _slope(lambda r: _values(text, place, rate + r * axis), 1e-3)

        slope = _slope(lambda s, axis=axis: _values(text, q + s * axis, qd), STEP)
        _close(jets[:, 4 + c], _slope(momentum, 1e-3) - slope)


def test_rows_and_names_are_counted(motion):
    features = FeatureMap(t1.kinetic, 2)
    assert features.names == ("xd^2", "thetad^2", "xd thetad cos(theta)")
    assert features.mass_pairs == ((0, 0), (0, 1), (1, 1))
    assert features.jets(*(np.tile(part, (4, 1, 1)) for part in motion)).shape == (4, 5, 2 + 4 + 3, 3)
    assert FeatureMap(t2.kinetic, 3).names == ("qd0", "qd1", "qd2", "cos(q1)", "cos(q2)")
