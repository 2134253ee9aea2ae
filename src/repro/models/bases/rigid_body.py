"""A rigid body in the plane: mass, inertia and weight, for the free rod."""

from repro.models.products import Features, Maths, Scalars

LINEAR = True
COORDINATES = ("m", "m", "rad")


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of T, for the centre of mass and the angle."""
    xd, yd, rate = qd
    return {"xd^2 + yd^2": xd**2 + yd**2, "thetad^2": rate**2}


def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of V."""
    return {"y": q[1]}
