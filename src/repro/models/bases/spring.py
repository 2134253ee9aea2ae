"""A mass on a spring whose force is odd: quadratic T, V of even powers."""

from collections.abc import Sequence
from typing import Any

from repro.models.products import Features

LINEAR = True
COORDINATES = ("m",)


def kinetic(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """Features of T."""
    return {"xd^2": qd[0] ** 2}


def potential(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """Features of V."""
    return {"x^2": q[0] ** 2, "x^4": q[0] ** 4}
