"""The options of a stored fit, read back from its run.json."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import TypeAdapter

from repro.errors import UserError
from repro.learning.objective_options import OBJECTIVES
from repro.learning.optimiser_options import OPTIMISERS
from repro.learning.sequence_options import SEQUENCES
from repro.learning.training_options import Training
from repro.mechanics.system_options import SystemOptions
from repro.models.model_options import MODELS
from repro.pipeline.stage_options import FitOptions
from repro.plugins.checked import checked
from repro.tracking.load import Run


def stored_options(fit: Run) -> FitOptions:
    """The options of a fit; UserError where its model does not exist any more, or has other options."""
    return _fit_options(fit.config)


def check_seeds(fit: Run, options: FitOptions, seeds: Sequence[int]) -> None:
    """UserError where a sub-model was not trained with one of these seeds."""
    if missing := [seed for seed in seeds if seed not in options.seeds]:
        raise UserError(f"model.parts: {fit.id} has the seeds {list(options.seeds)}, and not {missing}")


def _fit_options(content: Mapping[str, Any]) -> FitOptions:
    training = content["training"]
    return FitOptions(
        TypeAdapter(SystemOptions | None).validate_python(content["system"]),
        tuple(content["seeds"]),
        content["simulated"],
        checked("model", MODELS, content["model"]),
        content["basis"],
        None if training is None else _training(training),
        tuple(map(_fit_options, content["parts"])),
    )


def _training(content: Mapping[str, Any]) -> Training:
    return Training(
        checked("objective", OBJECTIVES, content["objective"]),
        checked("sequence", SEQUENCES, content["sequence"]),
        checked("optimiser", OPTIMISERS, content["optimiser"]),
        content["device"],
    )
