"""Raw coordinates [q; qd] into one network for the whole L: what III-A.1 improves on."""

from repro.models.products import Features, Maths, Scalars

LINEAR = False


def kinetic(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """Inputs of the network for L."""
    return {f"q{i}": value for i, value in enumerate(q)} | {f"qd{i}": value for i, value in enumerate(qd)}


def potential(q: Scalars, qd: Scalars, m: Maths) -> Features:
    """No separate V: the network stands for T - V."""
    return {}
