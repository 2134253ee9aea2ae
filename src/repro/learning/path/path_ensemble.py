"""The path fit of every member of an ensemble, from weights that the momentum balance has found."""

from dataclasses import replace

import numpy as np

from repro.data.dataset import Dataset
from repro.learning.full_batch import merge_curves
from repro.learning.path.path_fit import fit_path
from repro.learning.path.path_options import PathOptions
from repro.learning.result import Fitted, Notes, Progress
from repro.models.model import Model


def fit_paths(model: Model, dataset: Dataset, options: PathOptions, start: Fitted, progress: Progress) -> Fitted:
    """The ensemble with weights of maximum likelihood and their information; dataset: the training part."""
    members, fits = len(start.parameters), []
    for member, weights in enumerate(np.asarray(start.parameters, dtype=float)):

        def of_member(fraction: float, text: str, member: int = member) -> None:
            progress((member + fraction) / members, f"path: {text}")

        fits.append(fit_path(model, dataset, member, weights, options, of_member))
    curves = merge_curves([dict(enumerate(each.losses)) for each in fits], "path_loss")
    offset = start.curves[-1][0] if start.curves else 0
    own = Notes(cost_per_dof=[each.cost_per_dof for each in fits], noise=[each.noise.tolist() for each in fits])
    if options.zeros != "none":
        own["zeros"] = [each.zeros.tolist() for each in fits]
        own["zero_errors"] = [each.zero_errors.tolist() for each in fits]
    return replace(
        start,
        parameters=np.stack([each.parameters for each in fits]),
        curves=start.curves + [(offset + step, name, values) for step, name, values in curves],
        status=[old if old != "ok" else each.status for old, each in zip(start.status, fits, strict=True)],
        notes=start.notes | own,
        information=np.stack([each.information for each in fits]),
    )
