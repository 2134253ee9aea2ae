"""Fit a model to data, from Python."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from repro.data.dataset import Dataset
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.phases import TrainingData
from repro.learning.result import Progress, silent
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training_options import Training
from repro.library import choices
from repro.library.datasets import for_members, seed_list
from repro.library.ensemble import build_model, fit_ensemble
from repro.library.fitted_model import FittedModel
from repro.mechanics.system import System
from repro.models.model import Model
from repro.models.model_options import ModelOptions

if TYPE_CHECKING:
    from torch import nn


def fit(
    data: Dataset,
    model: "str | ModelOptions | Callable[[], nn.Module]" = "structured",
    *,
    objective: str | ObjectiveOptions = "inverse",
    optimiser: str | OptimiserOptions = "levenberg_marquardt",
    basis: str = "raw",
    seeds: int | Sequence[int] = 1,
    sequence: str | SequenceOptions = "main",
    free: Dataset | None = None,
    system: System | None = None,
    device: str = "cpu",
    progress: Progress = silent,
) -> FittedModel:
    """Fit one model per seed to the training part of the data.

    Parameters
    ----------
    data
        One member for all seeds, or one per seed; see `repro.dataset` and `repro.simulate`.
    model
        A name ("structured", "lagrangian", ...), what `repro.model` returns, or a class or function that returns a
        `torch.nn.Module` for L(q, qd), (T, V), qdd(q, qd, tau) or the parts of a port-Hamiltonian system, see
        `repro.models.module_model.Form`.
    objective
        A name, such as "inverse" (the error of tau) or "forward" (of qdd), or what `repro.objective` returns.
    optimiser
        A name, or what `repro.optimiser` returns.
    basis
        Features of T and V, for the models that have some: a file of models/bases.
    seeds
        How many members, or the seed of each: it draws the start and the order of the batches.
    sequence, free
        In which order D and D_H (`free`: motion without force, of known energy) are learned; a name, or what
        `repro.sequence` returns.
    system
        The true system, for models and sequences that need it.
    device
        "cpu" or "cuda".
    progress
        Called with the share that is done and a few words.

    Returns
    -------
    FittedModel
        The ensemble; equal to what `repro run` stores for the same choices, to the bit.

    Raises
    ------
    UserError
        For choices that do not exist or do not fit each other.

    Examples
    --------
    >>> import repro
    >>> data = repro.simulate("sip", samples=1000, reset="random")
    >>> fitted = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares")
    >>> bool(fitted.score(data).loc["mae_tau", 0] < 1e-9)
    True
    """
    numbers = seed_list(seeds)
    whole = for_members(data, len(numbers))
    training = Training(
        choices.objective(objective) if isinstance(objective, str) else objective,
        choices.sequence(sequence) if isinstance(sequence, str) else sequence,
        choices.optimiser(optimiser) if isinstance(optimiser, str) else optimiser,
        device,
    )
    model = choices.model(model) if isinstance(model, str) else model
    if isinstance(model, ModelOptions):
        built: Model = build_model(model, basis, [whole], system)
    else:
        from repro.models.module_model import ModuleModel

        built = ModuleModel(model, whole.n_q)
    trained = TrainingData([whole], free, system, numbers)
    fitted, seconds = fit_ensemble(built, training, trained, progress)
    weights = np.asarray(fitted.parameters, dtype=float)
    return FittedModel(
        built, weights, numbers, whole, tuple(fitted.status), seconds, fitted.curves, system, fitted.information,
        fitted.notes,
    )  # fmt: skip
