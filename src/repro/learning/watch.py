"""What is looked at while a fit goes on, to be drawn beside its loss."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.data.dataset import Dataset
from repro.learning.result import Curve
from repro.mechanics.system import System
from repro.models.model import Model, tensors
from repro.models.passivity_margin import States, worst_margin
from repro.models.terms import least_eigenvalue


class Watch(Protocol):
    """Evaluated for each member during a fit: with `always` at every step, else now and then."""

    @property
    def name(self) -> str:
        """Of its curve."""

    @property
    def always(self) -> bool:
        """Whether it is evaluated at every step."""

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """A number of each member (member,), or several, at the weights (member, n_parameters) of a step."""

    def member(self, index: int) -> "Watch":
        """The same for one member alone."""


@dataclass(frozen=True)
class PassivityWatch:
    """The worst margin of each member, computed while a fit goes on.

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
        """Itself: all members use the same states."""
        return self


@dataclass(frozen=True)
class WeightsKept:
    """The weights themselves, in the place of a watch whose states are not known during this fit.

    alone: one member after another is fitted, and so watched, which rounds otherwise than all together.
    """

    name: str
    always: bool
    alone: bool = False

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """The weights (member, n_parameters); (member, 1, n_parameters) of members that are fitted alone."""
        weights = parameters.detach().double().numpy().copy()
        return weights[:, None] if self.alone else weights

    def member(self, index: int) -> "WeightsKept":
        """The same for one member alone."""
        return replace(self, alone=True)


def watched(curves: Curve, watches: Sequence[Watch]) -> Curve:
    """Learning curves with every watch evaluated at the weights that were kept in its place."""
    named = {watch.name: watch for watch in watches}
    return [
        (step, name, _evaluated(named[name], values) if values.ndim > 1 else values) for step, name, values in curves
    ]


def _evaluated(watch: Watch, weights: np.ndarray) -> np.ndarray:
    if weights.ndim == 2:
        return watch(torch.from_numpy(weights))
    return np.concatenate([watch.member(index)(torch.from_numpy(one)) for index, one in enumerate(weights)])


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
