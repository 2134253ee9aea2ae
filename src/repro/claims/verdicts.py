"""A claim and the stored runs in, a verdict out: by rule, never by hand."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import assert_never

from repro.claims.claims import Claim, ClaimKind, Tolerance
from repro.claims.evidence import Evidence
from repro.claims.verdict_kind import VerdictKind
from repro.results.metric_names import metric_named
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import DEGENERATE, ORACLE, TRIVIAL, NotRunError, anchor, test_set_of
from repro.results.statistics import NOTHING, Estimate

VERDICTS = tuple(VerdictKind)
FULL_SCALE = "paper"


@dataclass(frozen=True)
class Verdict:
    """One row of the verdict table.

    `preview`: not the paper's protocol at full length. `flag`: what weakens a good verdict (an anchor reaches it too).
    """

    claim: Claim
    verdict: VerdictKind
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
    evidence = Evidence(results, claim.experiment)
    try:
        match claim.kind:
            case ClaimKind.STATEMENT:
                return _statement(claim, evidence)
            case ClaimKind.NUMBER | ClaimKind.DECLARED:
                return _number(claim, evidence)
            case _:
                assert_never(claim.kind)
    except NotRunError as reason:
        note = f"{claim.reason}; {reason}" if claim.reason else str(reason)
        return Verdict(claim, _without_judgement(claim), claim.quantity, claim.unit, NOTHING, note=note)


def verdict_of_number(
    measured: Estimate, printed: float, tolerance: Tolerance, *, lower_is_better: bool = True
) -> VerdictKind:
    """Apply the rule for numbers: matched by tolerance, else better or worse by the whole interval, else inconclusive.

    A setting of which a member failed is never `better`; one of which the median member failed is `worse`.
    """
    least, greatest = tolerance.around(printed)
    if least <= measured.median <= greatest:
        return VerdictKind.MATCHED
    if not math.isfinite(measured.median):
        return VerdictKind.WORSE
    below, above = measured.high < printed, measured.low > printed
    better, worse = (below, above) if lower_is_better else (above, below)
    if better:
        return VerdictKind.INCONCLUSIVE if measured.failed else VerdictKind.BETTER
    return VerdictKind.WORSE if worse else VerdictKind.INCONCLUSIVE


def _without_judgement(claim: Claim) -> VerdictKind:
    return VerdictKind(claim.declared) if claim.declared else VerdictKind.NOT_RUN


def _number(claim: Claim, evidence: Evidence) -> Verdict:
    setting, measured = evidence.measured(claim.selector, claim.metric)
    verdict, flag = _without_judgement(claim), ""
    if claim.printed is not None and claim.tolerance is not None:
        lower_is_better = metric_named(claim.metric).lower_is_better
        verdict = verdict_of_number(measured, claim.printed, claim.tolerance, lower_is_better=lower_is_better)
        if verdict in (VerdictKind.MATCHED, VerdictKind.BETTER):
            flag = _flag(claim, evidence, setting, claim.tolerance.around(claim.printed), lower_is_better)
    notes = [claim.reason] if claim.reason else []
    if measured.failed:
        notes.append(f"{measured.failed} of {measured.n} members failed")
    full_scale = evidence.results.scale == FULL_SCALE
    if full_scale and not setting.as_printed:
        notes.append("not the paper's full protocol")
    return Verdict(
        claim,
        verdict,
        claim.metric,
        claim.unit,
        measured,
        preview=not full_scale or not setting.as_printed,
        stale=setting.stale,
        flag=flag,
        note="; ".join(notes),
        runs=setting.run_ids,
        commands=(setting.command,) if setting.command else (),
    )


def _statement(claim: Claim, evidence: Evidence) -> Verdict:
    assert claim.predicate is not None
    finding = claim.predicate.judge(evidence)
    return Verdict(
        claim,
        VerdictKind.MATCHED if finding.holds else VerdictKind.NOT_REPRODUCED,
        finding.quantity,
        finding.unit,
        finding.estimate,
        preview=evidence.results.scale != FULL_SCALE,
        stale=finding.stale,
        note=finding.note,
        runs=finding.runs,
        commands=finding.commands,
    )


def _flag(
    claim: Claim, evidence: Evidence, setting: RunSetting, matched: tuple[float, float], lower_is_better: bool
) -> str:
    """Name the anchors that do as well: without any learning (trivial, degenerate), or with the truth (the oracle)."""
    least, greatest = matched
    scores = {
        name: measured.estimate(claim.metric).median
        for name in (TRIVIAL, DEGENERATE, ORACLE)
        if (measured := anchor(evidence.results, claim.experiment, name, test_set_of(setting.card))) is not None
    }
    reached = [
        f"{name} {score:.3g}"
        for name, score in scores.items()
        if least <= score <= greatest or (name != ORACLE and (score < least if lower_is_better else score > greatest))
    ]
    return "also reached by: " + ", ".join(reached) if reached else ""
