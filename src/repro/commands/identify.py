"""`repro identify`: which combinations of terms of a linear basis some data determine, before anything is fitted."""

from collections.abc import Sequence
from functools import partial

from repro.commands.arguments import command_parser
from repro.config.compose import compose
from repro.config.rules import linear
from repro.errors import UserError
from repro.evaluation.identifiability import Identifiability
from repro.launch import own_progress
from repro.learning.objective_options import Equation
from repro.pipeline.plan import Pipeline
from repro.pipeline.stages import data
from repro.pipeline.stages.examine import identified
from repro.pipeline.stages.fit import training_data
from repro.pipeline.stages.stored_fit import model_of
from repro.tracking import progress
from repro.tracking.load import Run
from repro.tracking.paths import outputs_root
from repro.tracking.store import Store

EXAMPLES = """examples:
  repro identify system=dip basis=fxf sequence=pretrain_only        what force-free motion of known energy determines
  repro identify system=dip basis=fxf_gauge sequence=joint sequence.energy_form=sum
  repro identify basis=library data.episode_steps=100
  repro identify basis=t1 data=file data.path=my.csv             of a recording of your own
Settings are those of `repro run`; each phase of the sequence is examined, for the first seed unless seeds= is set.
A combination consists of terms of T, unless V is named.
"""


def main(argv: Sequence[str]) -> int:
    """Examine the training data of a configuration and print rank, condition and null directions."""
    description = "Rank, condition and the combinations of terms that the data do not determine, for a linear basis."
    parser = command_parser("identify", description, EXAMPLES)
    parser.add_argument("overrides", nargs="*", metavar="key=value")
    overrides = parser.parse_args(argv).overrides
    if not any(override.startswith("seeds=") for override in overrides):
        overrides.append("seeds=1")
    with own_progress.shown("identify"):
        examined = _examined(overrides)
    for phase, members in examined.items():
        print(report(phase, members))
    return 0


def report(phase: str, members: Sequence[Identifiability]) -> str:
    """One phase: the first member in full, and the ranks of the others where they differ."""
    one = members[0]
    ranks = sorted({other.rank for other in members})
    lines = [
        f"{phase}: rank {one.rank} of {len(one.names)} terms",
        f"  condition {one.condition_raw:.3g}, with columns of unit norm {one.condition_scaled:.3g}",
        f"  singular values: {_value(one, one.rank - 1)} the smallest that counts, {_value(one, one.rank)} the next",
    ]
    if len(ranks) > 1:
        lines.append(f"  of {len(members)} members the ranks differ: {', '.join(map(str, ranks))}")
    lines.append("  not determined by these data:" if one.words else "  every term is determined")
    return "\n".join([*lines, *(f"    {words}" for words in one.words)])


def _examined(overrides: Sequence[str]) -> dict[str, list[Identifiability]]:
    composed = compose(overrides)
    config = composed.config
    if not linear(config) or config.objective.kind is not Equation.INVERSE:
        chosen = f"model={config.model.kind}, basis={config.basis.name}, objective={config.objective.kind}"
        raise UserError(f"identify is for model=lagrangian with a linear basis and objective=inverse, not {chosen}")
    pipeline, store = Pipeline.of(config, composed.command), Store(outputs_root())
    upstream = {}
    for number, (role, stage) in enumerate(pipeline.data_stages.items(), start=1):
        progress.report(0.1 * number, f"data: {role}")
        upstream[role] = Run(store.compute(stage, partial(data.make, options=pipeline.data_options[role])))
    options = pipeline.fit_options
    progress.report(0.5, "rank and null directions")
    model = model_of(options, upstream)
    return identified(model, config.objective, config.sequence, training_data(options, upstream))


def _value(one: Identifiability, order: int) -> str:
    inside = 0 <= order < len(one.singular_values)
    return f"{one.singular_values[order]:.2g}" if inside else "none"
