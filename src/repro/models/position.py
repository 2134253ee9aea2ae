"""Position features {cos, sin} of every angle: what a mass matrix of linked bodies on a cart depends on."""

from collections.abc import Sequence
from typing import Any


def kinetic(q: Sequence[Any], qd: Sequence[Any], m: Any) -> dict[str, Any]:
    """Inputs of a network for M(q); the cart's position is cyclic and is left out."""
    angles = list(enumerate(q))[1:]
    return {f"cos(q{i})": m.cos(angle) for i, angle in angles} | {f"sin(q{i})": m.sin(angle) for i, angle in angles}


def potential(q: Sequence[Any], qd: Sequence[Any], m: Any) -> dict[str, Any]:
    """Features of V: the cosines (V1)."""
    return {f"cos(q{i})": m.cos(angle) for i, angle in list(enumerate(q))[1:]}
