"""What sensors recorded, beside the estimates of motion that were made from it."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

EXACT = 1e-6  # m, rad, m/s, rad/s: standard deviation that stands for a sensor without noise


@dataclass(frozen=True)
class Measurement:
    """Recorded positions, and velocities where there are any: (member, sample, n_q), NaN where a sample is missing.

    q_noise, qd_noise, tau_noise: standard deviations (n_q,) of the sensors, None where they are not known.
    """

    q: np.ndarray
    qd: np.ndarray | None = None
    q_noise: np.ndarray | None = None
    qd_noise: np.ndarray | None = None
    tau_noise: np.ndarray | None = None

    def changed(self, change: Callable[[np.ndarray], np.ndarray]) -> "Measurement":
        """The same with both recorded arrays changed."""
        return replace(self, q=change(self.q), qd=None if self.qd is None else change(self.qd))

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that is there, by name, as it is stored."""
        named = {f"measured.{field.name}": getattr(self, field.name) for field in fields(self)}
        return {name: array for name, array in named.items() if array is not None}

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> "Measurement | None":
        """Taken out of stored arrays, None where no sensor is described."""
        own = {name.partition(".")[2]: arrays.pop(name) for name in [*arrays] if name.startswith("measured.")}
        return cls(**own) if own else None
