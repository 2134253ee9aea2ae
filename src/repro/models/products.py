"""Products of named factors: the distinct entries of a Kronecker product F (x) F, and quadratic forms in words."""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

Scalars = Sequence[Any]  # one number, or expression of a maths namespace, per coordinate
Maths = Any  # such a namespace: it has cos and sin
Features = dict[str, Any]  # by name

TIMES, SQUARED = " * ", "^2"


def pairwise(factors: Features) -> Features:
    """All products of two of n factors, each once: n (n + 1) / 2 of the n^2 entries of F (x) F differ."""
    return {_product(a, b): x * y for (a, x), (b, y) in itertools.combinations_with_replacement(factors.items(), 2)}


def square_root(names: Sequence[str], coefficients: np.ndarray, tolerance: float = 1e-6) -> dict[str, float] | None:
    """Factors r with coefficients . names = (sum of r)^2, or None where the combination is no square.

    names: products as `pairwise` names them; coefficients: (n_names,). The tolerance is relative to the largest.
    """
    terms = [(_factors(name), value) for name, value in zip(names, coefficients, strict=True) if value]
    if not terms or any(pair is None for pair, _ in terms):
        return None
    words = list(dict.fromkeys(word for pair, _ in terms for word in pair or ()))
    form = np.zeros((len(words), len(words)))
    for pair, value in terms:
        i, j = (words.index(word) for word in pair or ())
        form[i, j] += value / 2
        form[j, i] += value / 2
    values, vectors = np.linalg.eigh(form)
    largest = np.abs(values).max()
    if values[-1] < largest or np.abs(values[:-1]).max(initial=0.0) > tolerance * largest:
        return None
    root = vectors[:, -1] * np.sqrt(values[-1])
    root *= np.sign(root[np.abs(root).argmax()])
    return {word: float(value) for word, value in zip(words, root, strict=True) if abs(value) > tolerance}


def _product(a: str, b: str) -> str:
    if a != b:
        return a + TIMES + b
    return (f"({a})" if " " in a else a) + SQUARED


def _factors(name: str) -> tuple[str, str] | None:
    if name.endswith(SQUARED) and TIMES not in name:
        word = name.removesuffix(SQUARED)
        word = word[1:-1] if word.startswith("(") else word
        return word, word
    first, times, second = name.partition(TIMES)
    return (first, second) if times else None
