"""A claim and the stored runs in, a verdict out: by rule, never by hand."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from repro.claims.claims import Claim, ClaimKind
from repro.claims.evidence import Answer, Evidence, Ruling
from repro.claims.verdict_kind import CLASSES, VerdictClass, VerdictKind
from repro.results.metric_names import metric_named
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import DEGENERATE, ORACLE, TRIVIAL, NotRunError, anchor, test_set_of
from repro.results.statistics import BY_RANK, FEWEST, NOTHING, Estimate, prediction_interval

FULL_SCALE = "paper"
WIDEST = 100.0  # a prediction interval over more than this factor excludes too little to support a number
# From the weakest: a claim of several parts is counted under the first of these that one of them has.
WEAKEST_FIRST = (
    VerdictClass.NOT_SUPPORTED,
    VerdictClass.NOT_RUN,
    VerdictClass.UNDECIDED,
    VerdictClass.WITH_CHANGES,
    VerdictClass.SUPPORTED,
    VerdictClass.BY_CONSTRUCTION,
)


@dataclass(frozen=True, kw_only=True)
class Verdict(Answer):
    """One row of the verdict table."""

    claim: Claim
    verdict: VerdictKind
    leaning: VerdictKind  # what the point estimate alone says, where the interval decides nothing
    # where one more member falls with 95 %, which a printed number is compared with
    prediction: tuple[float, float] = (math.nan, math.nan)
    preview: bool = False  # from a smaller scale
    flag: str = ""  # what weakens a good verdict: an anchor satisfies it too
    cure: "Verdict | None" = None  # the smallest change that makes it hold, with its own verdict

    @property
    def counted_as(self) -> VerdictClass:
        """The class under which it is counted; a number that nearly anything would be consistent with is undecided."""
        low, high = self.prediction
        vague = self.verdict is VerdictKind.CONSISTENT and low > 0 and high > WIDEST * low
        return VerdictClass.UNDECIDED if vague else CLASSES[self.verdict]


def judge_all(claims: Sequence[Claim], results: Results) -> list[Verdict]:
    """Judge every claim on the same results."""
    return [judge(claim, results) for claim in claims]


def judge(claim: Claim, results: Results) -> Verdict:
    """Judge one claim by its kind; `not run` where no stored run answers it."""
    evidence = Evidence(results, claim.experiment)
    try:
        verdict = (_statement if claim.kind is ClaimKind.STATEMENT else _number)(claim, evidence)
        verdict = replace(verdict, preview=results.scale != FULL_SCALE)
    except NotRunError as reason:
        note = f"{claim.reason}; {reason}" if claim.reason else str(reason)
        kind = VerdictKind(claim.declared or VerdictKind.NOT_RUN)
        verdict = Verdict(claim.quantity, claim.unit, NOTHING, note, claim=claim, verdict=kind, leaning=kind)
    return replace(verdict, cure=_cure(claim, results))


def verdict_of_number(printed: float, members: Sequence[float] | np.ndarray, *, log: bool) -> VerdictKind:
    """Apply the rule for numbers: a printed value is one draw of an unknown seed, ours are the members' values.

    Consistent within the prediction interval, or among our members where these are too few to form one by rank.
    """
    low, high = prediction_interval(members, log=log)
    finished = np.asarray(members)[np.isfinite(members)]
    if math.isnan(low):
        return VerdictKind.TOO_FEW
    amid = finished.size < BY_RANK and finished.min() <= printed <= finished.max()
    return VerdictKind.CONSISTENT if amid or low <= printed <= high else VerdictKind.OUTSIDE


def _number(claim: Claim, evidence: Evidence) -> Verdict:
    setting, measured = evidence.measured(claim.selector, claim.metric)
    metric, values = metric_named(claim.metric), setting.values(claim.metric)
    log = metric.scale == "log"
    prediction = prediction_interval(values, log=log)
    verdict = leaning = VerdictKind(claim.declared or VerdictKind.NOT_RUN)
    flag, notes = "", [claim.reason] if claim.reason else []
    if claim.printed is not None and not claim.declared:
        verdict = leaning = verdict_of_number(claim.printed, values, log=log)
        if verdict is VerdictKind.CONSISTENT:
            flag = _flag(claim, evidence, setting, prediction)
        if measured.n < FEWEST:
            verdict = VerdictKind.TOO_FEW
        notes.append(_rank(claim.printed, values, measured, prediction, metric.lower_is_better))
    if measured.failed:
        notes.append(f"{measured.failed} of {measured.n} members failed")
    answer = (claim.metric, claim.unit, measured, "; ".join(notes), setting.rows)
    return Verdict(*answer, claim=claim, verdict=verdict, leaning=leaning, prediction=prediction, flag=flag)


def _statement(claim: Claim, evidence: Evidence) -> Verdict:
    assert claim.predicate is not None
    found = claim.predicate.judge(evidence)
    reason = claim.by_construction or claim.with_changes
    holds = VerdictKind.WITH_CHANGES if claim.with_changes else VerdictKind.SUPPORTED
    holds = VerdictKind.BY_CONSTRUCTION if claim.by_construction else holds
    verdict = {
        Ruling.HOLDS: holds,
        Ruling.FAILS: VerdictKind.NOT_SUPPORTED,
        Ruling.OPEN: VerdictKind.UNDECIDED,
        Ruling.DEPENDS: VerdictKind.UNDER_SPECIFIED,
    }[found.decision.outcome]
    if found.estimate.n < FEWEST and verdict is not VerdictKind.UNDER_SPECIFIED:
        verdict = VerdictKind.TOO_FEW
    leaning = holds if found.decision.leans else VerdictKind.NOT_SUPPORTED
    note = "; ".join(part for part in (reason, found.note) if part)
    answer = (found.quantity, found.unit, found.estimate, note, found.rows, found.other)
    return Verdict(*answer, claim=claim, verdict=verdict, leaning=leaning)


def _cure(claim: Claim, results: Results) -> Verdict | None:
    """The verdict on the claim's smallest change, by the same rules; None where none is named or was found."""
    if claim.cure is None or claim.cure.predicate is None:
        return None
    cure, fields = claim.cure, claim.model_dump(include={"id", "part", "section", "quote"})
    fields |= {"experiment": cure.experiment or claim.experiment, "with_changes": cure.change, "about": cure.change}
    return judge(Claim(**fields, kind=ClaimKind.STATEMENT, predicate=cure.predicate), results)


def _rank(
    printed: float, values: np.ndarray, measured: Estimate, prediction: tuple[float, float], lower_is_better: bool
) -> str:
    """Where a printed number stands among our members, and what our median says of it."""
    finished = values[np.isfinite(values)]
    note = f"{int(np.sum(finished < printed))} of {finished.size} members below the printed value"
    if not math.isnan(prediction[0]):
        note += f", one more falls within [{prediction[0]:.3g}, {prediction[1]:.3g}]"
        if prediction[0] > 0 and prediction[1] > WIDEST * prediction[0]:
            note += f", a factor of {prediction[1] / prediction[0]:.2g}, which excludes too little"
    if measured.low > printed or measured.high < printed:
        note += f"; our median is {'better' if (measured.high < printed) == lower_is_better else 'worse'}"
    return note


def _flag(claim: Claim, evidence: Evidence, setting: RunSetting, prediction: tuple[float, float]) -> str:
    """Name the anchors that lie in the prediction interval too: without learning, or with the truth (the oracle)."""
    scores = {
        name: measured.estimate(claim.metric).median
        for name in (TRIVIAL, DEGENERATE, ORACLE)
        if (measured := anchor(evidence.results, claim.experiment, name, test_set_of(setting.card))) is not None
    }
    reached = [f"{name} {score:.3g}" for name, score in scores.items() if prediction[0] <= score <= prediction[1]]
    return "also reached by: " + ", ".join(reached) if reached else ""


def counts_of_claims(verdicts: Sequence[Verdict]) -> Mapping[VerdictClass, int]:
    """Return class -> the number of claims in it, for the classes that occur, in the order of the front page."""
    found: dict[str, set[VerdictClass]] = {}
    for verdict in verdicts:
        found.setdefault(verdict.claim.id, set()).add(verdict.counted_as)
    counted = Counter(min(kinds, key=WEAKEST_FIRST.index) for kinds in found.values())
    return {kind: counted[kind] for kind in VerdictClass if counted[kind]}


def headline(verdicts: Sequence[Verdict]) -> str:
    """Write the counts of claims in one line: 24 claims: 8 supported, 3 undecided."""
    counts = counts_of_claims(verdicts)
    return f"{sum(counts.values())} claims: " + ", ".join(f"{number} {kind}" for kind, number in counts.items())
