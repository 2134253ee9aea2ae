"""The runs behind the sensitivities: which run takes whose place, and the claims judged again with it there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from repro.claims.claims import Claim
from repro.claims.verdicts import NOT_RUN, Verdict, judge
from repro.results.gather import gather_runs
from repro.results.results import Case, Results, Sensitivity, typed
from repro.results.schema import CARD
from repro.results.stored import StoredRun, read_json

if TYPE_CHECKING:
    import pandas as pd

METRIC = "metric="
NOT_NEEDED = ("curves", "trajectories", "closed_loops", "identifiability")
# The columns by which a claim finds its runs: those of a run in another's place are taken from that other.
DESCRIBED: Mapping[str, Sequence[str]] = {
    "runs": ("setting", *CARD),
    "metrics": ("setting", *CARD),
    "control": (
        *("setting", "system", "model", "basis", "hidden", "objective", "optimiser", "energies", "task"),
        *("intervals", "adaptive", "discretisation", "solver", "mismatch", "mismatch_kind", "noise", "friction"),
    ),
}


@dataclass(frozen=True)
class Comparison:
    """A claim judged twice: by our choice, and by what was put in its place."""

    assumption: str
    choice: str
    alternative: str
    ours: Verdict
    other: Verdict

    @property
    def moved(self) -> bool | None:
        """Whether the verdict is another; None where either was not run."""
        return None if NOT_RUN in (self.ours.verdict, self.other.verdict) else self.ours.verdict != self.other.verdict


def gather_sensitivity(lists: Sequence[Path], runs: Sequence[StoredRun]) -> Sensitivity | None:
    """Gather the sensitivity runs and the cases that their lists name; None where there are no runs.

    Raises UserError naming a damaged file.
    """
    if not runs:
        return None
    empty: dict[str, Any] = {name: typed(name, []) for name in NOT_NEEDED}
    cases = tuple(Case(**case) for path in lists for case in read_json(path).get("cases", []))
    return Sensitivity(replace(gather_runs(runs, []), **empty), cases)


def comparisons(sensitivity: Sensitivity, claims: Sequence[Claim]) -> list[Comparison]:
    """Judge every claim of every case by our choice and by the alternative, in the order of the cases."""
    named = {claim.name: claim for claim in claims}
    groups: dict[tuple[str, str, str], list[Case]] = {}
    for case in sensitivity.cases:
        if case.claim in named:
            groups.setdefault((case.assumption, case.alternative, case.claim), []).append(case)
    judging = _Judge(sensitivity.results)
    return [
        Comparison(
            assumption=assumption,
            choice=next((case.choice for case in cases if case.choice), f"{METRIC}{_metric(named[name])}"),
            alternative=alternative,
            ours=judging.judged(named[name], cases[0].experiment, {case.run: case.run for case in cases}),
            other=judging.judged(
                _measured_by(named[name], alternative),
                cases[0].experiment,
                {case.run: case.instead for case in cases},
            ),
        )
        for (assumption, alternative, name), cases in groups.items()
    ]


def _metric(claim: Claim) -> str:
    return claim.metric or str(claim.predicate.get("metric", ""))


def _measured_by(claim: Claim, alternative: str) -> Claim:
    """The claim with another metric, where that is the alternative."""
    if not alternative.startswith(METRIC):
        return claim
    metric = alternative.removeprefix(METRIC)
    if claim.kind == "statement":
        return replace(claim, predicate={**claim.predicate, "metric": metric})
    return replace(claim, metric=metric)


class _Judge:
    """Judges claims on a few runs at a time; each verdict once."""

    def __init__(self, results: Results) -> None:
        self.results = results
        self.tables = {name: getattr(results, name) for name in DESCRIBED}
        self.places = {name: table.groupby(["experiment", "run"]).indices for name, table in self.tables.items()}
        self.known: dict[tuple[str, str, tuple[tuple[str, str], ...]], Verdict] = {}

    def judged(self, claim: Claim, experiment: str, places: Mapping[str, str]) -> Verdict:
        """Judge a claim where the runs {ours: instead} take the places of ours."""
        key = (claim.name, _metric(claim), tuple(places.items()))
        if key not in self.known:
            tables: dict[str, Any] = {name: self._standing_in(name, experiment, places) for name in DESCRIBED}
            self.known[key] = judge(claim, replace(self.results, **tables))
        return self.known[key]

    def _standing_in(self, name: str, experiment: str, places: Mapping[str, str]) -> "pd.DataFrame":
        """The rows of the runs that stand in, described as ours are, so that a claim finds them."""
        import pandas as pd

        parts = [self._described(name, experiment, ours, instead) for ours, instead in places.items()]
        filled = [part for part in parts if len(part)]
        return pd.concat(filled, ignore_index=True) if filled else self.tables[name].iloc[:0]

    def _described(self, name: str, experiment: str, ours: str, instead: str) -> "pd.DataFrame":
        rows, example = self._rows(name, experiment, instead), self._rows(name, experiment, ours)
        if rows.empty or example.empty or ours == instead:
            return rows
        columns = [*DESCRIBED[name]]
        first = example[columns].iloc[[0] * len(rows)].set_axis(rows.index)
        return rows.drop(columns=columns).join(first)

    def _rows(self, name: str, experiment: str, run: str) -> "pd.DataFrame":
        return self.tables[name].iloc[self.places[name].get((experiment, run), [])]
