"""What a model is built for: the coordinates, the basis, and the spread of the training data."""

from dataclasses import dataclass
from types import ModuleType

import numpy as np

from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.system import System
from repro.models.features import FeatureMap
from repro.models.model import Model
from repro.models.position import PositionFeatures, position_features


@dataclass(frozen=True)
class SubModel:
    """A trained sub-model: a model and the weights of its members (member, n_parameters)."""

    model: Model
    parameters: np.ndarray


@dataclass(frozen=True)
class Context:
    """What `build` of every kind of model is handed.

    q, qd: training samples (member, sample, n_q); first_qd: those of the phase that training starts with.
    system: the true system, or None for one's own recordings. parts: trained sub-models that the model is made of.
    """

    basis: ModuleType
    coordinates: tuple[Coordinate, ...]
    q: np.ndarray
    qd: np.ndarray
    first_qd: np.ndarray
    system: System | None
    parts: tuple[SubModel, ...] = ()

    @property
    def n_q(self) -> int:
        """Number of generalised coordinates."""
        return int(self.q.shape[-1])

    @property
    def true_system(self) -> System:
        """The true system; UserError where it is not known."""
        if self.system is None:
            raise UserError("this model is made from the true system: it cannot be used with data=file")
        return self.system

    @property
    def position_scale(self) -> np.ndarray:
        """Standard deviation of each coordinate over all training samples (n_q,), 1 where it is constant."""
        return spread_of(self.q)

    @property
    def positions(self) -> PositionFeatures:
        """What of a position a network is shown."""
        return position_features(self.coordinates, self.position_scale)

    @property
    def velocity_scale(self) -> np.ndarray:
        """Standard deviation of each velocity where training starts (n_q,), 1 where it does not move."""
        return spread_of(self.first_qd)

    @property
    def feature_scale(self) -> np.ndarray:
        """Standard deviation of each kinetic feature over all training samples, 1 where it is constant."""
        features = FeatureMap(self.basis.kinetic, self.n_q)
        return spread_of(features.jets(self.q, self.qd, np.zeros_like(self.q))[..., 0, :])


def spread_of(values: np.ndarray) -> np.ndarray:
    """Standard deviation of each component (n,) over all values (..., n), 1 where it is constant."""
    spread = values.reshape(-1, values.shape[-1]).std(axis=0)
    return np.where(spread > 0, spread, 1.0)
