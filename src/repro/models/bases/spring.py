"""A mass on a spring whose force is odd: quadratic T, V of even powers."""

from repro.models.products import Features, Maths, Scalars

LINEAR = True
COORDINATES = ("m",)


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of T."""
    return {"xd^2": qd[0] ** 2}


def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of V."""
    return {"x^2": q[0] ** 2, "x^4": q[0] ** 4}
