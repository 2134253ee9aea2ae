"""F (x) F, and what a network for T can also hold but tau cannot see: a constant, cosines, terms linear in velocity."""

from repro.models.bases import fxf
from repro.models.products import Features, Maths, Scalars

LINEAR, COORDINATES, potential = fxf.LINEAR, fxf.COORDINATES, fxf.potential


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """F (x) F with gauge terms: L + constant and L + dF(q)/dt move alike, and cos(th) may stand in T or in V."""
    return fxf.kinetic(q, qd, m) | {"1": 1.0} | fxf.potential(q, qd, m) | fxf.factors(q, qd, m)
