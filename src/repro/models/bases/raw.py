"""Raw coordinates [q; qd] into one network for the whole L: what III-A.1 improves on."""

from collections.abc import Sequence
from typing import Any

from repro.models.products import Features

LINEAR = False


def kinetic(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """Inputs of the network for L."""
    return {f"q{i}": value for i, value in enumerate(q)} | {f"qd{i}": value for i, value in enumerate(qd)}


def potential(q: Sequence[Any], qd: Sequence[Any], m: Any) -> Features:
    """No separate V: the network stands for T - V."""
    return {}
