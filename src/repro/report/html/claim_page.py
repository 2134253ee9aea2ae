"""One claim as its page shows it: the paper's words, the rule, and what our runs say."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from repro.report.verdicts import Verdict


def rule(verdict: Verdict) -> Mapping[str, str]:
    """Return how a claim is judged, as titled lines in plain words."""
    claim = verdict.claim
    lines = {"experiment": claim.experiment}
    if claim.selector:
        lines["runs meant"] = _spelled(claim.selector)
    if claim.predicate:
        lines["question asked"] = _spelled({key: value for key, value in claim.predicate.items() if value != {}})
    if claim.tolerance is not None:
        least, greatest = claim.tolerance.around(claim.printed or 0.0)
        lines["counts as matched"] = f"{least:.3g} to {greatest:.3g} ({claim.tolerance})"
        lines["why so far"] = claim.tolerance.reason
    if claim.declared:
        lines["declared"] = f"{claim.declared}: {claim.reason}"
    return lines


def facts(verdict: Verdict) -> Mapping[str, Any]:
    """Return the numbers behind a verdict at full precision."""
    return {"verdict": verdict.verdict, "metric": verdict.quantity, "unit": verdict.unit, **asdict(verdict.estimate)}


def _spelled(mapping: Mapping[str, Any]) -> str:
    import yaml

    return str(yaml.safe_dump(dict(mapping), sort_keys=False, allow_unicode=True, width=90)).strip()
