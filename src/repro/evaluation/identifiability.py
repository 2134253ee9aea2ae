"""What data can tell of a basis: rank, condition, and the combinations of terms that they cannot see, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from repro.models.products import square_root

CUTOFF = 1e-8  # of the largest singular value of the unit columns: below it a direction counts as unseen
NEGLIGIBLE = 1e-7  # of the largest coefficient of a combination


@dataclass(frozen=True)
class Identifiability:
    """The regression of one member, seen through its columns scaled to unit norm.

    names: of the columns, those of T first (n_kinetic of them), then those of V; singular_values: of the unit columns,
    relative to the largest, falling (n_columns,); condition_raw and condition_scaled: ratio of the largest to the least
    singular value that counts, before and after scaling; null_directions: the sparsest combinations found that change
    no row, (n_columns - rank, n_columns), the largest coefficient of each being 1.
    """

    names: tuple[str, ...]
    n_kinetic: int
    singular_values: np.ndarray
    rank: int
    condition_raw: float
    condition_scaled: float
    null_directions: np.ndarray

    @property
    def words(self) -> tuple[str, ...]:
        """The null directions as sums of terms of T and V, written as a square where they are one."""
        return tuple(self._spell(direction) for direction in self.null_directions)

    def _spell(self, direction: np.ndarray) -> str:
        kinetic, potential = direction[: self.n_kinetic], direction[self.n_kinetic :]
        parts = [_sum(self.names[: self.n_kinetic], kinetic), _sum(self.names[self.n_kinetic :], potential)]
        if not potential.any():
            root = square_root(self.names[: self.n_kinetic], kinetic) or {}
            return f"({_sum(tuple(root), np.array([*root.values()]))})^2" if len(root) > 1 else parts[0]
        return f"V: {parts[1]}" if not kinetic.any() else f"T: {parts[0]}, V: {parts[1]}"


def identifiability(
    matrix: np.ndarray, names: Sequence[str], n_kinetic: int, cutoff: float = CUTOFF
) -> Identifiability:
    """Examine a regression matrix (n_rows, n_columns); singular values below `cutoff` of the largest count as zero."""
    n = matrix.shape[1]
    if len(matrix) > n:
        matrix = qr(matrix, mode="r")[0][:n]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    _, values, right = np.linalg.svd(matrix / scale)
    values = np.pad(values, (0, n - len(values)))
    rank = int((values > cutoff * values[0]).sum()) if values[0] else 0
    raw = np.linalg.svd(matrix, compute_uv=False)
    seen = slice(max(rank - 1, 0), max(rank, 1))
    null = right[rank:] / scale
    return Identifiability(
        names=tuple(names),
        n_kinetic=n_kinetic,
        singular_values=values / values[0] if values[0] else values,
        rank=rank,
        condition_raw=float(raw[0] / raw[seen][0]) if rank else np.inf,
        condition_scaled=float(values[0] / values[seen][0]) if rank else np.inf,
        null_directions=_sparse_basis(null, matrix / scale, scale),
    )


def _sparse_basis(null: np.ndarray, unit: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """A basis of the row space of `null` (k, n) with few terms in each: for every column the vector of least l1 norm.

    Each is then sharpened on its own support, where it is the direction in which the unit columns add up to nothing.
    """
    k, n = null.shape
    if k == 0:
        return null
    span = np.linalg.qr(null.T)[0].T
    found = [_least_l1(span, column) for column in range(n) if np.abs(span[:, column]).max() > NEGLIGIBLE]
    sharpened = [_sharpened(np.flatnonzero(vector), unit, scale) for vector in found]
    sharpened.sort(key=lambda vector: (np.count_nonzero(vector), -np.flatnonzero(vector)[-1]))
    chosen: list[np.ndarray] = []
    for vector in sharpened:
        stacked = np.array([*chosen, vector])
        if np.linalg.matrix_rank(stacked / np.linalg.norm(stacked, axis=1)[:, None], tol=1e-6) > len(chosen):
            chosen.append(vector)
    return np.array(chosen)


def _least_l1(span: np.ndarray, column: int) -> np.ndarray:
    """The vector v = span' z with v[column] = 1 and the least sum of |v|, small entries cut off."""
    from scipy.optimize import linprog

    k, n = span.shape
    # unknowns: z, and t >= |span' z|
    limits = np.block([[span.T, -np.eye(n)], [-span.T, -np.eye(n)]])
    equal = np.concatenate([span[:, column], np.zeros(n)])[None]
    cost = np.concatenate([np.zeros(k), np.ones(n)])
    free = [(None, None)] * k + [(0, None)] * n
    solved = linprog(cost, A_ub=limits, b_ub=np.zeros(2 * n), A_eq=equal, b_eq=[1.0], bounds=free)
    vector: np.ndarray = solved.x[:k] @ span
    return np.where(np.abs(vector) > NEGLIGIBLE * np.abs(vector).max(), vector, 0.0)


def _sharpened(support: np.ndarray, unit: np.ndarray, scale: np.ndarray) -> np.ndarray:
    vector = np.zeros(unit.shape[1])
    vector[support] = np.linalg.svd(unit[:, support])[2][-1] / scale[support]
    size = np.abs(vector)
    largest = float(vector[np.flatnonzero(size > (1 - NEGLIGIBLE) * size.max())[0]])
    return vector / largest


def _sum(names: Sequence[str], coefficients: np.ndarray) -> str:
    terms = []
    for name, value in zip(names, coefficients, strict=True):
        if value:
            size = f"{abs(value):.6g}"
            sign = "-" if value < 0 else "+"
            terms.append((sign, name if size == "1" else f"{size} {name}"))
    first, *others = terms or [("+", "0")]
    return ("-" if first[0] == "-" else "") + first[1] + "".join(f" {sign} {term}" for sign, term in others)
