"""F (x) F of velocities and velocities times cos and sin (V-B), equal products merged: 28 of the 49 for two links."""

from typing import Any

from repro.models.products import Features, Maths, Scalars, pairwise

LINEAR = True
COORDINATES = ("m", "rad", ...)  # a cart and any number of links


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Distinct products of F; the merged ones carry the sum of the two weights that the paper gives them."""
    return pairwise(factors(q, qd, m))


def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of V: the cosine of every angle."""
    return {f"cos({name})": m.cos(angle) for name, angle in _angles(q)}


def factors(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """F = [xd; thd_i sin(th_i); thd_i cos(th_i); thd_i], for any number of links."""
    turning = list(zip(_angles(q), qd[1:], strict=True))
    found = {"xd": qd[0]}
    for (name, angle), rate in turning:
        found[f"{name}d sin({name})"] = rate * m.sin(angle)
        found[f"{name}d cos({name})"] = rate * m.cos(angle)
    return found | {f"{name}d": rate for (name, _), rate in turning}


def _angles(q: Scalars) -> list[tuple[str, Any]]:
    """Angles by name, as the systems call them: theta alone, else theta1, theta2, ..."""
    angles = list(q[1:])
    return [("theta", angles[0])] if len(angles) == 1 else [(f"theta{i}", a) for i, a in enumerate(angles, start=1)]
