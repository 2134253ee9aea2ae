"""How a claim is judged, in words."""

from collections.abc import Mapping
from typing import Any

from repro.claims.verdicts import Verdict


def rule(verdict: Verdict) -> Mapping[str, str]:
    """Return titled lines: which runs are meant or what is asked of them, and what counts as matched, why."""
    claim = verdict.claim
    lines = {"experiment": claim.experiment}
    if claim.selector:
        lines["runs meant"] = _spelled(claim.selector)
    if claim.predicate is not None:
        parameters = claim.predicate.model_dump(exclude_unset=True)
        lines["question asked"] = _spelled({key: value for key, value in parameters.items() if value != {}})
    if claim.tolerance is not None:
        least, greatest = claim.tolerance.around(claim.printed or 0.0)
        lines["counts as matched"] = f"{least:.3g} to {greatest:.3g} ({claim.tolerance})"
        lines["why so far"] = claim.tolerance.reason
    if claim.declared:
        lines["declared"] = f"{claim.declared}: {claim.reason}"
    return lines


def _spelled(mapping: Mapping[str, Any]) -> str:
    import yaml

    return str(yaml.safe_dump(dict(mapping), sort_keys=False, allow_unicode=True, width=90)).strip()
