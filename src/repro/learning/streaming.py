"""Least squares over more samples than memory holds: only a triangle is kept of all rows seen."""

from collections.abc import Iterable

import numpy as np
from scipy.linalg import qr

from repro.learning.least_squares import solve


def streamed_solve(blocks: Iterable[tuple[np.ndarray, np.ndarray]], cutoff: float) -> tuple[np.ndarray, int]:
    """Least squares of all blocks [matrix (rows, n), right (rows,)] together, and the rank; see `solve`.

    Sequential QR (Demmel et al. 2012): the triangle of the rows so far is factorised together with the next block, so
    that the condition number is never squared.
    """
    triangle = None
    for matrix, right in blocks:
        rows = np.column_stack([matrix, right])
        rows = rows if triangle is None else np.vstack([triangle, rows])
        triangle = qr(rows, mode="r", overwrite_a=True, check_finite=False)[0][: rows.shape[1]]
    if triangle is None:
        raise ValueError("least squares of no rows at all")
    return solve(triangle[:, :-1], triangle[:, -1], cutoff)
