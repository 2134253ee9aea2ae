"""One joint that carries a rigid body: T = J thetad^2 / 2, and gravity from any zero of the angle."""

from collections.abc import Sequence
from typing import Any

from repro.models.products import Features

LINEAR = True
COORDINATES = ("rad",)


def kinetic(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """Features of T."""
    return {"thetad^2": qd[0] ** 2}


def potential(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """Features of V."""
    return {"cos(theta)": m.cos(q[0]), "sin(theta)": m.sin(q[0])}
