"""How a claim is judged, in words."""

import math
from collections.abc import Mapping
from typing import Any

from repro.claims.verdicts import Verdict
from repro.report.tables.verdicts import cure


def rule(verdict: Verdict) -> Mapping[str, str]:
    """Return titled lines: which runs are meant, the criterion, and what the verdict depends on."""
    claim = verdict.claim
    lines = {"experiment": claim.experiment}
    if claim.selector:
        lines["runs meant"] = _spelled(claim.selector)
    if claim.predicate is not None:
        parameters = claim.predicate.model_dump(exclude_unset=True)
        lines["criterion"] = _spelled({key: value for key, value in parameters.items() if value != {}})
    if claim.printed is not None and not math.isnan(verdict.prediction[0]):
        low, high = verdict.prediction
        lines["consistent with"] = f"{low:.3g} to {high:.3g}, where one more member falls with 95 %"
    if claim.by_construction:
        lines["cannot fail"] = claim.by_construction
    if claim.with_changes:
        lines["needs of ours"] = claim.with_changes
    if verdict.claim.cure:
        lines["smallest change that makes it hold"] = cure(verdict)
    if claim.history:
        lines["changed after results"] = "\n".join(f"{one.commit}: {one.change}. {one.reason}" for one in claim.history)
    if claim.declared:
        lines["declared"] = f"{claim.declared}: {claim.reason}"
    return lines


def _spelled(mapping: Mapping[str, Any]) -> str:
    import yaml

    return str(yaml.safe_dump(dict(mapping), sort_keys=False, allow_unicode=True, width=90)).strip()
