"""`repro identify`: which combinations of terms of a linear basis some data determine, before anything is fitted."""

from argparse import Namespace
from collections.abc import Sequence

import numpy as np

from repro.config.compose import compose
from repro.config.rules import linear
from repro.errors import UserError
from repro.evaluation.identifiability import Identifiability
from repro.evaluation.uncertainty import Uncertainty, expected_errors, in_words
from repro.launch import own_progress
from repro.learning.phases import TrainingData
from repro.learning.result import Fitted
from repro.library.ensemble import fit_ensemble
from repro.models.damped import without_damping
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import work_of
from repro.pipeline.stages.examine import identified
from repro.pipeline.stages.fit import training_data
from repro.pipeline.stages.stored_fit import model_of
from repro.tracking import progress
from repro.tracking.paths import outputs_root
from repro.tracking.store import Store

ONE_PERCENT = 0.01


def main(arguments: Namespace) -> int:
    """Examine the training data of a configuration and print rank, condition and null directions."""
    overrides = arguments.overrides
    if not any(override.startswith("seeds=") for override in overrides):
        overrides.append("seeds=1")
    with own_progress.shown("identify"):
        examined, lines = _examined(overrides)
    print("\n".join([*(_report(phase, members) for phase, members in examined.items()), *lines]))
    return 0


def _report(phase: str, members: Sequence[Identifiability]) -> str:
    """One phase: the first member in full, and the ranks of the others where they differ."""
    one, ranks = members[0], sorted({other.rank for other in members})
    last, following = (
        f"{one.singular_values[order]:.2g}" if 0 <= order < len(one.singular_values) else "none"
        for order in (one.rank - 1, one.rank)
    )
    lines = [
        f"{phase}: rank {one.rank} of {len(one.names)} terms",
        f"  condition {one.condition_raw:.3g}, with columns of unit norm {one.condition_scaled:.3g}",
        f"  singular values: {last} the smallest that counts, {following} the next",
    ]
    if len(ranks) > 1:
        lines.append(f"  of {len(members)} members the ranks differ: {', '.join(map(str, ranks))}")
    lines.append("  not determined by these data:" if one.words else "  every term is determined")
    return "\n".join([*lines, *(f"    {words}" for words in one.words)])


def _examined(overrides: Sequence[str]) -> tuple[dict[str, list[Identifiability]], list[str]]:
    composed = compose(overrides)
    config = composed.config
    if not linear(config) or not config.objective.linear:
        chosen = f"model={config.model.kind}, basis={config.basis.name}, objective={config.objective.kind}"
        raise UserError(
            f"identify is for model=lagrangian with a linear basis and objective=inverse, balance or path, not {chosen}"
        )
    pipeline, store = Pipeline.of(config, composed.command), Store(outputs_root())
    upstream = {}
    for number, (role, stage) in enumerate(pipeline.data_stages.items(), start=1):
        progress.report(0.1 * number, f"data: {role}")
        upstream[role] = store.compute(stage, work_of(stage, {}))
    options = pipeline.fit_options
    progress.report(0.5, "rank and null directions")
    model = model_of(options, upstream)
    given = training_data(options, upstream)
    lines = []
    if config.objective.is_likelihood:
        progress.report(0.6, "path fit")
        lines = _accuracy(model, fit_ensemble(model, options.training, given)[0], given)
    return identified(model, config.objective, config.sequence, given), lines


def _accuracy(model: Model, fitted: Fitted, given: TrainingData) -> list[str]:
    """What a path fit of the first member says: coefficients with standard errors, and seconds of data for 1 %."""
    assert fitted.information is not None
    data, weights, information = given.forced[-1], np.asarray(fitted.parameters[0]), fitted.information[0]
    learned = without_damping(model)
    n_kinetic = len(learned.kinetic_features) if isinstance(learned, Lagrangian) else 0
    known = Uncertainty.of(information)
    words = in_words(model, weights, information, n_kinetic)
    tau, qdd = expected_errors(model, weights, known, 0, data.test)
    share = np.abs(known.standard_errors / weights)
    finite = np.flatnonzero(np.isfinite(share))
    lines = [f"path fit: cost per degree of freedom {fitted.notes['cost_per_dof'][0]:.3f}, 1 is expected"]
    lines += [f"  {name}: {text}" for name, text in words.items()]
    lines.append(f"  expected errors: MAE tau {tau:.2g}, MAE qdd {qdd:.2g}")
    if len(finite):
        worst, seconds = finite[share[finite].argmax()], data.n_train * data.time_step
        known_to = f"{model.coefficient_names[worst]} is known to {share[worst]:.2g} of itself after {seconds:.3g} s"
        lines.append(f"  {known_to}; 1 % takes {seconds * (share[worst] / ONE_PERCENT) ** 2:.2g} s")
    return lines
