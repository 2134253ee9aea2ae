"""One joint that carries a rigid body: T = J thetad^2 / 2, and gravity from any zero of the angle."""

from repro.models.products import Features, Maths, Scalars

LINEAR = True
COORDINATES = ("rad",)


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of T."""
    return {"thetad^2": qd[0] ** 2}


def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of V."""
    return {"cos(theta)": m.cos(q[0]), "sin(theta)": m.sin(q[0])}
