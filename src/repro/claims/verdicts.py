"""A claim and the stored runs in, a verdict out: by rule, never by hand."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from repro.claims.claims import Claim, Tolerance
from repro.claims.predicate_registry import ask
from repro.claims.predicates import Evidence
from repro.results.metric_names import metric_named
from repro.results.results import Results
from repro.results.selectors import DEGENERATE, ORACLE, TRIVIAL, NotRunError, Setting, anchor, one_setting, test_set_of
from repro.results.statistics import NOTHING, Estimate

MATCHED, BETTER, WORSE, INCONCLUSIVE = "matched", "better", "worse", "inconclusive"
NOT_REPRODUCED, NOT_RUN = "not reproduced", "not run"
VERDICTS = (MATCHED, BETTER, WORSE, INCONCLUSIVE, NOT_REPRODUCED, "not comparable", "under-specified", NOT_RUN)
FULL_SCALE = "paper"


@dataclass(frozen=True)
class Verdict:
    """One row of the verdict table.

    `preview`: not the paper's protocol at full length. `flag`: what weakens a good verdict (an anchor reaches it too).
    """

    claim: Claim
    verdict: str
    quantity: str
    unit: str
    estimate: Estimate
    preview: bool = False
    stale: bool = False
    flag: str = ""
    note: str = ""
    runs: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()


def judge_all(claims: Sequence[Claim], results: Results) -> list[Verdict]:
    """Judge every claim on the same results."""
    return [judge(claim, results) for claim in claims]


def judge(claim: Claim, results: Results) -> Verdict:
    """Judge one claim by its kind; `not run` where no stored run answers it."""
    try:
        return _statement(claim, results) if claim.kind == "statement" else _number(claim, results)
    except NotRunError as reason:
        verdict = claim.declared or NOT_RUN
        note = f"{claim.reason}; {reason}" if claim.reason else str(reason)
        quantity = claim.metric or str(claim.predicate.get("metric", ""))
        return Verdict(claim, verdict, quantity, claim.unit, NOTHING, note=note)


def verdict_of_number(found: Estimate, printed: float, tolerance: Tolerance, *, lower_is_better: bool = True) -> str:
    """Apply the rule for numbers: matched by tolerance, else better or worse by the whole interval, else inconclusive.

    A setting of which a member failed is never `better`; one of which the median member failed is `worse`.
    """
    least, greatest = tolerance.around(printed)
    if least <= found.median <= greatest:
        return MATCHED
    if not math.isfinite(found.median):
        return WORSE
    below, above = found.high < printed, found.low > printed
    better, worse = (below, above) if lower_is_better else (above, below)
    if better:
        return INCONCLUSIVE if found.failed else BETTER
    return WORSE if worse else INCONCLUSIVE


def _number(claim: Claim, results: Results) -> Verdict:
    setting = one_setting(results, claim.experiment, claim.selector)
    found = setting.estimate(claim.metric)
    if found.n == 0:
        raise NotRunError(f"{claim.metric} was not measured in {claim.experiment}")
    verdict, flag = claim.declared, ""
    if claim.printed is not None and claim.tolerance is not None:
        lower_is_better = metric_named(claim.metric).lower_is_better
        verdict = verdict_of_number(found, claim.printed, claim.tolerance, lower_is_better=lower_is_better)
        if verdict in (MATCHED, BETTER):
            flag = _flag(claim, results, setting)
    notes = [claim.reason] if claim.reason else []
    if found.failed:
        notes.append(f"{found.failed} of {found.n} members failed")
    if results.scale == FULL_SCALE and not setting.literal:
        notes.append("not the paper's full protocol")
    return Verdict(
        claim,
        verdict,
        claim.metric,
        claim.unit,
        found,
        preview=results.scale != FULL_SCALE or not setting.literal,
        stale=setting.stale,
        flag=flag,
        note="; ".join(notes),
        runs=setting.run_ids,
        commands=(setting.command,) if setting.command else (),
    )


def _statement(claim: Claim, results: Results) -> Verdict:
    outcome = ask(claim.predicate, Evidence(results, claim.experiment))
    runs = outcome.runs or tuple(run for setting in outcome.settings for run in setting.run_ids)
    commands = outcome.commands or tuple(setting.command for setting in outcome.settings if setting.command)
    return Verdict(
        claim,
        MATCHED if outcome.holds else NOT_REPRODUCED,
        outcome.quantity,
        outcome.unit,
        outcome.estimate,
        preview=results.scale != FULL_SCALE,
        stale=any(setting.stale for setting in outcome.settings),
        note=outcome.note,
        runs=tuple(dict.fromkeys(runs)),
        commands=tuple(dict.fromkeys(commands)),
    )


def _flag(claim: Claim, results: Results, setting: Setting) -> str:
    """Name the anchors that do as well: knowing nothing (trivial, degenerate), or knowing all (the oracle)."""
    if claim.printed is None or claim.tolerance is None:
        return ""
    least, greatest = claim.tolerance.around(claim.printed)
    lower_is_better = metric_named(claim.metric).lower_is_better
    scores: Mapping[str, float] = {
        name: found.estimate(claim.metric).median
        for name in (TRIVIAL, DEGENERATE, ORACLE)
        if (found := anchor(results, claim.experiment, name, test_set_of(setting.card))) is not None
    }
    reached = [
        name
        for name, score in scores.items()
        if least <= score <= greatest or (name != ORACLE and (score < least if lower_is_better else score > greatest))
    ]
    return "also reached by: " + ", ".join(f"{name} {scores[name]:.3g}" for name in reached) if reached else ""
