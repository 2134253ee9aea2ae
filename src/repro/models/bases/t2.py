"""T2 = {qd, cos(angles)}, fed into a network; V1 = {cos(angles)} (V-A.1). All coordinates but the cart's are angles."""

from repro.models.products import Features, Maths, Scalars

LINEAR = False
COORDINATES = ("m", "rad", ...)  # a cart and any number of links


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Inputs of the network for T."""
    velocities = {f"qd{i}": rate for i, rate in enumerate(qd)}
    return velocities | {f"cos(q{i})": m.cos(angle) for i, angle in enumerate(q) if i > 0}


def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of V."""
    return {f"cos(q{i})": m.cos(angle) for i, angle in enumerate(q) if i > 0}
