"""Engineered features [q; qd; cos q; sin q] into one network for the whole L (III-A.1)."""

from repro.models.bases import raw
from repro.models.products import Features, Maths, Scalars

LINEAR = False
potential = raw.potential


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Inputs of the network for L."""
    cosines = {f"cos(q{i})": m.cos(value) for i, value in enumerate(q)}
    sines = {f"sin(q{i})": m.sin(value) for i, value in enumerate(q)}
    return raw.kinetic(q, qd, m) | cosines | sines
