"""A rigid body in the plane: mass, inertia and weight, for the free rod."""

from collections.abc import Sequence
from typing import Any

from repro.models.products import Features

LINEAR = True
COORDINATES = ("m", "m", "rad")


def kinetic(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """Features of T, for the centre of mass and the angle."""
    xd, yd, rate = qd
    return {"xd^2 + yd^2": xd**2 + yd**2, "thetad^2": rate**2}


def potential(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """Features of V."""
    return {"y": q[1]}
