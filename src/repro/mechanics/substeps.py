"""How many integration sub-steps a time step is divided into."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LEAST = 10  # sub-steps for one angle
MOST = 2000
ANGLE = 0.06  # rad per sub-step for one angle: the energy balance of a step holds within 1e-4 J, also at 100 rad/s
CHAIN_EXPONENT = 1.5  # outer links of a chain turn faster: both bounds grow with this power of the number of links


@dataclass(frozen=True)
class SubstepRule:
    """Sub-steps of one step of time_step s: ceil(per_rate * fastest rate among `angles`), at least `least`.

    A trajectory that would need more than `most` is given up: its states are NaN from there on.
    """

    time_step: float
    angles: tuple[int, ...]
    least: float
    most: float
    per_rate: float

    @classmethod
    def for_angles(cls, time_step: float, angles: Sequence[int]) -> "SubstepRule":
        """As many sub-steps as keep the turn of every angle within one of them below ANGLE."""
        finer = max(1, len(angles)) ** CHAIN_EXPONENT
        return cls(time_step, tuple(angles), math.ceil(LEAST * finer), MOST, finer * time_step / ANGLE)

    def substeps(self, states: np.ndarray) -> np.ndarray:
        """Number of sub-steps (batch,) from states (batch, 2 n_q) = [q, qd]; 0 where a trajectory is given up."""
        rates = np.abs(states[:, [states.shape[1] // 2 + i for i in self.angles]])
        counts = np.maximum(self.least, np.ceil(self.per_rate * rates.max(axis=1, initial=0.0)))
        followed = np.isfinite(states).all(axis=1) & (counts <= self.most)
        return np.where(followed, counts, 0).astype(int)
