"""What is looked at while a fit goes on, to be drawn beside its loss."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.data.dataset import Dataset
from repro.mechanics.system import System
from repro.models.model import Model, tensors
from repro.models.passivity_margin import States, worst_margin
from repro.models.terms import least_eigenvalue


class Watch(Protocol):
    """A number of each member, evaluated during a fit: with `always` at every step, else now and then."""

    name: ClassVar[str]
    always: ClassVar[bool]

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """The number (member,) at the weights (member, n_parameters) of a step."""

    def member(self, index: int) -> "Watch":
        """The same for one member alone."""


@dataclass(frozen=True)
class PassivityWatch:
    """The worst margin of each member, asked for while a fit goes on.

    storage: the true system, whose energy a model without an energy of its own is judged by; None for the model's own.
    """

    name: ClassVar[str] = "passivity_margin"
    always: ClassVar[bool] = True

    model: Model
    states: States
    storage: System | None = None

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """Worst margin (member,) of weights (member, n_parameters)."""
        return worst_margin(self.model, parameters.detach().double().numpy(), self.states, self.storage)

    def member(self, index: int) -> "PassivityWatch":
        """Itself: all members are asked at the same states."""
        return self


STATES = 256


@dataclass(frozen=True)
class InertiaWatch:
    """The least eigenvalue of each member's mass matrix (kg, kg m^2) over states of its own."""

    name: ClassVar[str] = "min_eig_M"
    always: ClassVar[bool] = False

    model: Model
    prepared: Mapping[str, np.ndarray]

    @classmethod
    def over(cls, model: Model, part: Dataset) -> "InertiaWatch":
        """Over at most `STATES` samples of a dataset, evenly spread."""
        index = np.linspace(0, part.samples - 1, min(STATES, part.samples)).astype(int)
        arrays = (np.ascontiguousarray(array[:, index]) for array in (part.q, part.qd, part.qdd, part.tau))
        return cls(model, model.prepare(*arrays))

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """Least eigenvalue (member,) at weights (member, n_parameters)."""
        prepared = tensors(self.prepared)
        with torch.no_grad():
            mass = self.model.evaluate(parameters.double(), prepared, mass=True).mass
        return least_eigenvalue(mass.numpy())

    def member(self, index: int) -> "InertiaWatch":
        """The same for one member alone."""
        return replace(self, prepared={name: array[index : index + 1] for name, array in self.prepared.items()})
