"""What an assumption does to a claim: the claim judged by the runs of our choice, and by those of an alternative."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from repro.claims.claims import Claim
from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import Verdict, judge
from repro.results.gather import Gathering, gather
from repro.results.results import Results, typed
from repro.results.stored import Stored
from repro.results.table_schema import CARD, LOOP_CARD, records
from repro.tracking.experiment_list import Case
from repro.tracking.lazy_pandas import pd

METRIC = "metric="
NOT_NEEDED = ("curves", "trajectories", "closed_loops", "identifiability", "bench")
# By table: the columns by which a claim finds a run, which are the same in all rows of one run.
FOUND_BY: Mapping[str, Sequence[str]] = {"runs": ["setting", "config", "changed", *CARD], "control": [*LOOP_CARD]}


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


def gather_sensitivity(tried: Stored, paper: Gathering) -> Results | None:
    """Gather the sensitivity runs and their cases; None without runs. Raises UserError for a damaged file."""
    if not tried.runs:
        return None
    return replace(gather(tried, paper), **{name: typed(name, []) for name in NOT_NEEDED})  # type: ignore[arg-type]


def assumption_effects(sensitivity: Results, claims: Sequence[Claim]) -> list[AssumptionEffect]:
    """Judge every claim of every case by our choice and by the alternative, in the order of the cases."""
    named = {claim.name: claim for claim in claims}
    groups: dict[tuple[str, str, str], list[Case]] = {}
    for case in (Case(**row) for row in records(sensitivity.cases)):
        if case.claim in named:
            groups.setdefault((case.assumption, case.alternative, case.claim), []).append(case)
    substituted = _Substitution(sensitivity).results
    effects = []
    for (assumption, alternative, name), cases in groups.items():
        claim, experiment = named[name], cases[0].experiment
        by_metric = alternative.startswith(METRIC)
        other = claim.by_metric(alternative.removeprefix(METRIC)) if by_metric else claim
        choice = next((case.choice for case in cases if case.choice), f"{METRIC}{claim.quantity}")
        ours = judge(claim, substituted(claim, experiment, {case.run: case.run for case in cases}))
        instead = judge(other, substituted(other, experiment, {case.run: case.instead for case in cases}))
        effects.append(AssumptionEffect(assumption, choice, alternative, ours, instead))
    return effects


class _Substitution:
    """Results of a few runs at a time, some in the place of others, shared by the claims on the same runs."""

    def __init__(self, results: Results) -> None:
        self.all = results
        self.tables = {"runs": results.runs, "control": results.control}
        self.places = {name: table.groupby(["experiment", "run"]).indices for name, table in self.tables.items()}
        self.made: dict[tuple[object, ...], Results] = {}

    def results(self, claim: Claim, experiment: str, substitutes: Mapping[str, str]) -> Results:
        """The results of the substitutes {our run: the run in its place}, each with the card of our run."""
        selected = {column for selector in claim.selectors for column in selector} - {*LOOP_CARD}
        extra = sorted(selected & {*self.tables["control"]})
        place = (experiment, *substitutes.items(), *extra)
        if place not in self.made:
            found_by = {**FOUND_BY, "control": [*FOUND_BY["control"], *extra]}
            tables = {name: self._rows(name, experiment, substitutes, columns) for name, columns in found_by.items()}
            self.made[place] = self.all.with_runs(**tables)
        return self.made[place]

    def _rows(
        self, name: str, experiment: str, substitutes: Mapping[str, str], columns: Sequence[str]
    ) -> "pd.DataFrame":
        """The rows of the substitutes with the columns by which a claim finds ours, where ours has one value there."""
        table, places, parts = self.tables[name], self.places[name], []
        for ours, other in substitutes.items():
            if (experiment, other) not in places:
                continue
            rows = table.iloc[places[experiment, other]]
            if ours != other and (experiment, ours) in places:
                example = table.iloc[places[experiment, ours]]
                fixed = [c for c in columns if c in FOUND_BY[name] or example[c].nunique(dropna=False) == 1]
                rows = rows.drop(columns=fixed).join(example[fixed].iloc[[0] * len(rows)].set_axis(rows.index))
            parts.append(rows)
        return pd.concat(parts, ignore_index=True) if parts else table.iloc[:0]
