"""Whether the learned mass matrix stays positive definite while a fit goes on."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor

from repro.data.dataset import Dataset
from repro.models.model import Model, Prepared

STATES = 256


@dataclass(frozen=True)
class InertiaWatch:
    """The least eigenvalue of each member's mass matrix (kg, kg m^2) over states of its own."""

    name: ClassVar[str] = "min_eig_M"
    always: ClassVar[bool] = False

    model: Model
    prepared: Prepared

    @classmethod
    def over(cls, model: Model, part: Dataset) -> "InertiaWatch":
        """Over at most `STATES` samples of a dataset, evenly spread."""
        index = np.linspace(0, part.samples - 1, min(STATES, part.samples)).astype(int)
        arrays = (np.ascontiguousarray(array[:, index]) for array in (part.q, part.qd, part.qdd, part.tau))
        return cls(model, {name: torch.from_numpy(array) for name, array in model.prepare(*arrays).items()})

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """Least eigenvalue (member,) at weights (member, n_parameters)."""
        with torch.no_grad():
            mass = self.model.evaluate(parameters.double(), self.prepared, mass=True).mass
        return least_eigenvalue(mass.numpy())

    def member(self, index: int) -> "InertiaWatch":
        """The same for one member alone."""
        return InertiaWatch(self.model, {name: array[index : index + 1] for name, array in self.prepared.items()})


def least_eigenvalue(mass: np.ndarray) -> np.ndarray:
    """Of each member's matrices (member, sample, n_q, n_q), (member,); 0 where a matrix is not finite."""
    finite = np.isfinite(mass).all((2, 3), keepdims=True)
    return np.linalg.eigvalsh(np.where(finite, mass, 0.0)).min((1, 2))
