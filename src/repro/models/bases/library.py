"""An over-complete library for basis selection: velocities times trigonometric functions for T, and a library for V."""

from typing import Any

from repro.models.products import Features, Maths, Scalars

LINEAR = True
COORDINATES = ("m", "rad")  # a cart and one link


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Monomials xd^a thetad^b, 1 <= a + b <= 4, times {1, cos, sin, cos 2, sin 2} up to order two, alone above."""
    (_, theta), (xd, thetad) = q, qd
    features: Features = {}
    for a, b in [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]:
        for name, value in _trigonometric(theta, m).items():
            features[f"xd^{a} thetad^{b} {name}"] = xd**a * thetad**b * value
    for a, b in [(3, 0), (2, 1), (1, 2), (0, 3), (4, 0), (2, 2), (0, 4)]:
        features[f"xd^{a} thetad^{b} 1"] = xd**a * thetad**b
    return features


def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Trigonometric functions of the angle, and a spring on the cart."""
    x, theta = q
    return {name: value for name, value in _trigonometric(theta, m).items() if name != "1"} | {"x": x, "x^2": x**2}


def _trigonometric(theta: Any, m: Maths) -> Features:
    return {
        "1": 1.0,
        "cos(theta)": m.cos(theta),
        "sin(theta)": m.sin(theta),
        "cos(2 theta)": m.cos(2 * theta),
        "sin(2 theta)": m.sin(2 * theta),
    }
