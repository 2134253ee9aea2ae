"""How a claim's predicate is found by name, checked, and asked."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from repro.claims import control_predicates, family_predicates, predicates
from repro.errors import UserError
from repro.results.schema import BENCH, CARD, CONTROL

PREDICATES: Mapping[str, Callable[..., predicates.Outcome]] = {
    predicate.__name__: predicate
    for predicate in (
        predicates.median_below,
        predicates.median_above,
        predicates.all_members_below,
        predicates.all_members_away_from,
        predicates.share_at_least,
        predicates.share_of_failures_at_least,
        predicates.paired_ratio_below,
        predicates.ratio_at_least,
        predicates.bench_ratio_above,
        family_predicates.every_setting_below,
        control_predicates.loops_succeed,
        control_predicates.loops_succeed_more_often,
        control_predicates.step_takes_longer,
    )
}


def ask(predicate: Mapping[str, Any], evidence: predicates.Evidence) -> predicates.Outcome:
    """Ask a checked predicate of the results. Raises NotRunError where no run answers."""
    arguments = {key: value for key, value in predicate.items() if key != "name"}
    return PREDICATES[predicate["name"]](evidence, **arguments)


def check_predicate(predicate: Any, place: str) -> None:
    """Refuse an unknown predicate, a missing or unknown argument, or one of the wrong kind. Raises UserError."""
    if not isinstance(predicate, dict) or predicate.get("name") not in PREDICATES:
        name = predicate.get("name") if isinstance(predicate, dict) else predicate
        message = f"{place}: no predicate is called {name!r}; allowed: {', '.join(PREDICATES)}"
        raise UserError(message)
    parameters = dict(list(inspect.signature(PREDICATES[predicate["name"]]).parameters.items())[1:])
    given = {key: value for key, value in predicate.items() if key != "name"}
    missing = [key for key, p in parameters.items() if p.default is p.empty and key not in given]
    unknown = [key for key in given if key not in parameters]
    if missing or unknown:
        faults = [f"needs {', '.join(missing)}"] if missing else []
        faults += [f"does not know {', '.join(unknown)}"] if unknown else []
        message = f"{place}: {predicate['name']} {' and '.join(faults)}; its arguments: {', '.join(parameters)}"
        raise UserError(message)
    for key, value in given.items():
        _check_argument(key, value, f"{place}: {predicate['name']}")


def _check_argument(key: str, value: Any, place: str) -> None:
    known = {"where": CARD, "against": CARD, "bench": BENCH, "loops": CONTROL, "other_loops": CONTROL}
    columns = known.get(key)
    if columns is not None:
        unknown = sorted(set(value) - set(columns)) if isinstance(value, dict) else [str(value)]
        if unknown:
            message = f"{place}: {key} names {', '.join(unknown)}; allowed: {', '.join(columns)}"
            raise UserError(message)
    elif key == "metrics":
        if not isinstance(value, list) or not value:
            message = f"{place}: metrics must be a list of metric names, not {value!r}"
            raise UserError(message)
    elif key != "metric" and (isinstance(value, bool) or not isinstance(value, int | float)):
        message = f"{place}: {key} must be a number, not {value!r}"
        raise UserError(message)
