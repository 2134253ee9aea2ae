"""How well the data determine the weights of a fit, and what follows for the force that it predicts."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from repro.codegen.lazy_torch import torch
from repro.errors import UserError
from repro.evaluation.uncertainty import Uncertainty
from repro.library.ensemble_model import Ensemble
from repro.models.model import tensors

SAMPLES = 2000  # of the training part, evenly spread, from which the information of a fit of tau is estimated


@dataclass(frozen=True)
class FitUncertainty:
    """The covariance of the weights of every member of an ensemble.

    information  (member, n_parameters, n_parameters), the Fisher information of the weights
    """

    ensemble: Ensemble
    information: np.ndarray

    @cached_property
    def members(self) -> tuple[Uncertainty, ...]:
        """Covariance and directions that the data do not determine, one per member."""
        return tuple(Uncertainty.of(each) for each in self.information)

    @property
    def standard_errors(self) -> np.ndarray:
        """Standard error of every weight, (member, n_parameters); infinite where the data do not determine it."""
        return np.stack([each.standard_errors for each in self.members])

    @property
    def table(self) -> pd.DataFrame:
        """Value and standard error of every weight, one row each, by its name; a pair of columns per seed."""
        model, seeds = self.ensemble.model, self.ensemble.seeds
        names = model.coefficient_names or [f"w[{number}]" for number in range(model.n_parameters)]
        columns = {
            (seed, kind): values
            for seed, weights, errors in zip(seeds, self.ensemble.weights_, self.standard_errors, strict=True)
            for kind, values in (("value", weights), ("standard error", errors))
        }
        return pd.DataFrame(columns, index=list(names))

    def tau(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> np.ndarray:
        """Standard deviation of the predicted force, as the weights are known; noise of a sensor is not in it.

        Parameters
        ----------
        q, qd, qdd
            Positions, velocities and accelerations (m, rad, s), (..., n_q); leading axes broadcast.

        Returns
        -------
        numpy.ndarray
            (member, ..., n_q) in N or N m.
        """
        arrays = np.broadcast_arrays(*(np.asarray(each, dtype=float) for each in (q, qd, qdd)))
        slopes = _slopes(self.ensemble, *(each.reshape(1, -1, each.shape[-1]) for each in arrays))[1]
        covariance = np.stack([each.covariance for each in self.members])
        variance = np.einsum("msiw,mwv,msiv->msi", slopes, covariance, slopes, optimize=True)
        deviation: np.ndarray = np.sqrt(np.maximum(variance, 0.0))
        return deviation.reshape(len(slopes), *arrays[0].shape)


def fit_uncertainty(ensemble: Ensemble) -> FitUncertainty:
    """See `FittedModel.uncertainty`."""
    if ensemble.information_ is not None:
        return FitUncertainty(ensemble, ensemble.information_)
    model, train = ensemble.model, ensemble.data.train
    if not model.inverse:
        raise UserError(f"{type(model).__name__} predicts no tau, from whose errors the uncertainty is estimated")
    every = slice(None, None, -(-train.samples // SAMPLES))
    tau, slopes = _slopes(ensemble, *(array[:, every] for array in (train.q, train.qd, train.qdd)))
    error = tau - train.tau[:, every]
    determined = max(1.0, train.samples - model.n_parameters / model.n_q)  # degrees of freedom of one component
    variance = (error**2).mean(1) * train.samples / determined
    variance = np.maximum(variance, np.finfo(float).tiny)
    information = np.einsum("msiw,msiv,mi->mwv", slopes, slopes, 1 / variance, optimize=True)
    return FitUncertainty(ensemble, information * train.samples / error.shape[1])


def _slopes(ensemble: Ensemble, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """tau_hat (member, sample, n_q) and its derivatives with respect to the weights (..., n_parameters)."""
    members = []
    for number, weights in enumerate(ensemble.weights_):
        own = (np.ascontiguousarray(array[min(number, len(array) - 1)][None]) for array in (q, qd, qdd, 0 * q))
        prepared, parameters = tensors(ensemble.model.prepare(*own)), torch.from_numpy(weights)[None]
        members.append(ensemble.model.rows(parameters, prepared, lambda terms: terms.tau, mass=False))
    values, jacobians = zip(*members, strict=True)
    return torch.cat(values).numpy(), torch.cat(jacobians).permute(0, 2, 1, 3).numpy()
