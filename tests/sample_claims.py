"""A claim on a number and a statement, as rows of claims.yaml and as claims."""

from typing import Any

from repro.claims.claims import Claim

TEXTS = {"section": "V", "quote": "q", "about": "a", "experiment": "sip_basis"}
PREDICATE = {"name": "median_below", "metric": "mae_tau", "value": 1.0, "where": {"basis": "t2"}}
STATEMENT = {"id": "C2", "kind": "statement", **TEXTS, "predicate": PREDICATE}
NUMBER = {
    "id": "C4",
    "kind": "number",
    **TEXTS,
    "metric": "mae_tau",
    "unit": "N",
    "printed": 0.3,
    "selector": {"basis": "t2"},
}


def number(**changes: Any) -> Claim:
    """The claim that MAE τ of T2/V1 is 0.3 N, with other values of some fields."""
    return Claim.model_validate({**NUMBER, **changes})


def statement(predicate: dict[str, Any] = PREDICATE, **changes: Any) -> Claim:
    """The claim that a predicate holds: MAE τ of T2/V1 lies below 1 N, if no other is given."""
    return Claim.model_validate({**STATEMENT, "predicate": predicate, **changes})
