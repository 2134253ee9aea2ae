"""What an assumption does to a claim: the claim judged by the runs of our choice, and by those of an alternative."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from repro.claims.claims import Claim
from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import Verdict, judge
from repro.results.gather import gather_runs
from repro.results.gathering import NO_PAPER, Gathering
from repro.results.results import Case, Results, Sensitivity, typed
from repro.results.stored import StoredRun, read_json
from repro.results.table_schema import CARD, LOOP_CARD

if TYPE_CHECKING:
    import pandas as pd

METRIC = "metric="
NOT_NEEDED = ("curves", "trajectories", "closed_loops", "identifiability")
# By table: the columns by which a claim finds a run, which are the same in all rows of one run.
FOUND_BY: Mapping[str, Sequence[str]] = {
    "runs": ["setting", "config", "changed", *CARD],
    "metrics": ["setting"],
    "control": [*LOOP_CARD],
}


@dataclass(frozen=True)
class AssumptionEffect:
    """A claim judged twice: by our choice, and by an alternative in its place."""

    assumption: str
    choice: str
    alternative: str
    ours: Verdict
    other: Verdict

    @property
    def moved(self) -> bool | None:
        """Whether the point estimates lean another way (few members decide nothing); None where one was not run."""
        if VerdictKind.NOT_RUN in (self.ours.verdict, self.other.verdict):
            return None
        return self.ours.leaning != self.other.leaning


def gather_sensitivity(
    lists: Sequence[Path], runs: Sequence[StoredRun], paper: Gathering = NO_PAPER
) -> Sensitivity | None:
    """Gather the sensitivity runs and the cases that their lists name; None where there are no runs.

    Raises UserError naming a damaged file.
    """
    if not runs:
        return None
    empty = {name: typed(name, []) for name in NOT_NEEDED}
    cases = tuple(Case(**case) for path in lists for case in read_json(path).get("cases", []))
    return Sensitivity(replace(gather_runs(runs, [], paper), **empty), cases)  # type: ignore[arg-type]


def assumption_effects(sensitivity: Sensitivity, claims: Sequence[Claim]) -> list[AssumptionEffect]:
    """Judge every claim of every case by our choice and by the alternative, in the order of the cases."""
    named = {claim.name: claim for claim in claims}
    groups: dict[tuple[str, str, str], list[Case]] = {}
    for case in sensitivity.cases:
        if case.claim in named:
            groups.setdefault((case.assumption, case.alternative, case.claim), []).append(case)
    judge_with = _Substitution(sensitivity.results)
    effects = []
    for (assumption, alternative, name), cases in groups.items():
        claim, experiment = named[name], cases[0].experiment
        by_metric = alternative.startswith(METRIC)
        other = claim.by_metric(alternative.removeprefix(METRIC)) if by_metric else claim
        effects.append(
            AssumptionEffect(
                assumption=assumption,
                choice=next((case.choice for case in cases if case.choice), f"{METRIC}{claim.quantity}"),
                alternative=alternative,
                ours=judge_with.runs(claim, experiment, {case.run: case.run for case in cases}),
                other=judge_with.runs(other, experiment, {case.run: case.instead for case in cases}),
            )
        )
    return effects


class _Substitution:
    """Judges claims on a few runs at a time, some in the place of others; each verdict is computed once."""

    def __init__(self, results: Results) -> None:
        self.results = results
        self.tables: dict[str, pd.DataFrame] = {name: getattr(results, name) for name in FOUND_BY}
        # The card stands in the runs, from which settings take it.
        self.tables["metrics"] = results.metrics.drop(columns=[*CARD])
        self.places = {name: table.groupby(["experiment", "run"]).indices for name, table in self.tables.items()}
        self.nothing = {name: table.iloc[:0] for name, table in self.tables.items()}
        self.verdicts: dict[tuple[str, str, tuple[tuple[str, str], ...]], Verdict] = {}
        self.substituted: dict[tuple[object, ...], Results] = {}

    def runs(self, claim: Claim, experiment: str, substitutes: Mapping[str, str]) -> Verdict:
        """Judge a claim by the substitutes {our run: the run in its place}, each with the card of our run."""
        key = (claim.name, claim.quantity, tuple(substitutes.items()))
        if key not in self.verdicts:
            selected = {column for selector in claim.selectors for column in selector} - {*LOOP_CARD}
            extra = sorted(selected & {*self.tables["control"]})
            place = (experiment, *substitutes.items(), *extra)
            if place not in self.substituted:  # shared by the claims on these runs
                found_by = {**FOUND_BY, "control": [*FOUND_BY["control"], *extra]}
                tables = {
                    name: self._substituted(name, experiment, substitutes, columns)
                    for name, columns in found_by.items()
                }
                self.substituted[place] = replace(self.results, **tables)  # type: ignore[arg-type]
            self.verdicts[key] = judge(claim, self.substituted[place])
        return self.verdicts[key]

    def _substituted(
        self, name: str, experiment: str, substitutes: Mapping[str, str], columns: Sequence[str]
    ) -> "pd.DataFrame":
        import pandas as pd

        stored = [pair for pair in substitutes.items() if (experiment, pair[1]) in self.places[name]]
        parts = [self._as_ours(name, experiment, ours, other, columns) for ours, other in stored]
        return pd.concat(parts, ignore_index=True) if parts else self.nothing[name]

    def _as_ours(self, name: str, experiment: str, ours: str, other: str, columns: Sequence[str]) -> "pd.DataFrame":
        """The rows of the other run with the columns by which a claim finds ours, where ours has one value there."""
        table, places = self.tables[name], self.places[name]
        rows = table.iloc[places[experiment, other]]
        if ours == other or (experiment, ours) not in places:
            return rows
        example = table.iloc[places[experiment, ours]]
        fixed = [c for c in columns if c in FOUND_BY[name] or example[c].nunique(dropna=False) == 1]
        first = example[fixed].iloc[[0] * len(rows)].set_axis(rows.index)
        return rows.drop(columns=fixed).join(first)
