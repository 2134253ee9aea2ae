"""Predictions of an ensemble at plain arrays, whose leading axes broadcast."""

import numpy as np
from numpy.typing import ArrayLike

from repro.errors import UserError
from repro.evaluation.predictions import predict
from repro.models.model import Model
from repro.models.terms import Terms

ALL = ("tau", "acceleration", "momentum", "kinetic", "potential", "mass")


def predicted(model: Model, parameters: np.ndarray, *arrays: ArrayLike | None) -> Terms:
    """Quantities (member, ..., n_q) of every member at q, qd and, where they are given, qdd and tau, (..., n_q) each.

    parameters: (member, n_parameters). UserError for arrays of another width.
    """
    given = np.broadcast_arrays(*(np.zeros(model.n_q) if a is None else np.asarray(a, float) for a in arrays))
    shape = given[0].shape
    if shape[-1:] != (model.n_q,):
        raise UserError(f"arrays of shape {shape}: the last axis needs {model.n_q} coordinates")
    flat = [np.repeat(array.reshape(1, -1, model.n_q), len(parameters), axis=0) for array in given]
    terms = predict(model, parameters, *flat, *[np.zeros_like(flat[0])] * (4 - len(flat)))
    defined = {name: value for name in ALL if (value := getattr(terms, name)) is not None}
    leading = len(parameters), *shape[:-1]
    return Terms(**{name: value.reshape(*leading, *value.shape[2:]) for name, value in defined.items()})
