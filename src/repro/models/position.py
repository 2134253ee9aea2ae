"""What of a position a network is shown: {cos, sin} of angles, and translations that the energies depend on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.mechanics.coordinate import Coordinate, jointed
from repro.models.products import Features, Maths, Scalars


@dataclass(frozen=True)
class PositionFeatures:
    """Features of q (n_q,): angles enter as cos and sin, translations (column, scale) divided by their scale in m.

    A cyclic coordinate, such as the position of a cart, changes neither T nor V, and so it is left out. jointed:
    coordinates whose friction acts on their rate relative to that of the one before.
    """

    angles: tuple[int, ...]
    translations: tuple[tuple[int, float], ...] = ()
    jointed: tuple[int, ...] = ()

    @property
    def upright_angles(self) -> bool:
        """Whether all that V depends on are angles from the vertical: one, and absolute ones."""
        return not self.translations and all(angle in self.jointed for angle in self.angles[1:])

    def inertia(self, q: Scalars, qd: Scalars, m: Maths) -> Features:
        """Inputs of a network for M(q), dimensionless, by name."""
        cosines = {f"cos(q{i})": m.cos(q[i]) for i in self.angles}
        sines = {f"sin(q{i})": m.sin(q[i]) for i in self.angles}
        return cosines | sines | self._moved(q)

    @property
    def size(self) -> int:
        """Number of inputs of a network for M(q)."""
        return 2 * len(self.angles) + len(self.translations)

    def values(self, q: Tensor) -> Tensor:
        """These inputs (..., n_z), differentiable in q (..., n_q)."""
        parts = [function(q[..., list(self.angles)]) for function in (torch.cos, torch.sin)]
        parts += [q[..., i : i + 1] / scale for i, scale in self.translations]
        return torch.cat(parts, dim=-1)

    def slopes(self, q: Tensor) -> Tensor:
        """Rows [z, dz/dq_1, ..] (..., 1 + n_q, n_z) of these inputs, differentiable in q (..., n_q)."""
        z = self.values(q)
        rows, count = z.new_zeros((*q.shape[:-1], 1 + q.shape[-1], self.size)), len(self.angles)
        rows[..., 0, :] = z
        for k, i in enumerate(self.angles):
            rows[..., 1 + i, k], rows[..., 1 + i, count + k] = -z[..., count + k], z[..., k]
        for k, (i, scale) in enumerate(self.translations, start=2 * count):
            rows[..., 1 + i, k] = 1 / scale
        return rows

    def potential(self, q: Scalars, qd: Scalars, m: Maths) -> Features:
        """Features of V by name: the cosines (V1), and the translations, in which a weight is linear."""
        return {f"cos(q{i})": m.cos(q[i]) for i in self.angles} | self._moved(q)

    def _moved(self, q: Scalars) -> Features:
        return {f"q{i}": q[i] / scale for i, scale in self.translations}


def position_features(coordinates: Sequence[Coordinate], scale: np.ndarray | None = None) -> PositionFeatures:
    """Features for these coordinates; scale: (n_q,) typical size of each in m (1 by default), used for translations."""
    sizes = np.ones(len(coordinates)) if scale is None else scale
    shown = [i for i, coordinate in enumerate(coordinates) if not coordinate.cyclic]
    angles = tuple(i for i in shown if coordinates[i].is_angle)
    moved = tuple((i, float(sizes[i])) for i in shown if not coordinates[i].is_angle)
    return PositionFeatures(angles, moved, jointed(coordinates))


def cart_with_links(n_q: int) -> PositionFeatures:
    """Features of a cart, whose position is cyclic, with n_q - 1 links."""
    return PositionFeatures(tuple(range(1, n_q)), jointed=tuple(range(2, n_q)))
