"""T1 = {xd^2, thd^2, xd thd cos th}, V1 = {cos th}: the products that the true SIP Lagrangian is made of (V-A.1)."""

from repro.models.bases import fxf
from repro.models.products import Features, Maths, Scalars

LINEAR = True
COORDINATES = ("m", "rad")  # a cart and one link
potential = fxf.potential


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Features of T, for a cart and one pendulum."""
    (_, theta), (xd, thetad) = q, qd
    return {"xd^2": xd**2, "thetad^2": thetad**2, "xd thetad cos(theta)": xd * thetad * m.cos(theta)}
