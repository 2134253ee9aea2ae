"""From a selector to the settings it means; which settings may be compared; the anchors of a test set."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.results.results import Results
from repro.results.run_setting import Setting
from repro.results.schema import CARD, TEST_SET, as_text, plain

if TYPE_CHECKING:
    import pandas as pd

Where = Mapping[str, Any]

TRIVIAL, DEGENERATE, ORACLE = "trivial", "degenerate", "oracle"
ANCHORS: Mapping[str, Where] = {
    TRIVIAL: {"model": "trivial"},
    DEGENERATE: {"model": "degenerate"},
    ORACLE: {"basis": ["t1", "fxf"], "optimiser": "least_squares", "sequence": "main"},
}


class NotRunError(Exception):
    """No stored run, or no single setting, answers the question: the message says which was looked for."""


def settings(results: Results, experiment: str | None, where: Where | None = None) -> list[Setting]:
    """List the settings of an experiment (None: of all) whose card agrees with `where` (a list: any of it)."""
    wanted = {column: _texts(value) for column, value in (where or {}).items()}
    found = []
    for setting in results.settings:
        if experiment in (None, setting.runs[0]["experiment"]):
            runs = tuple(run for run in setting.runs if all(as_text(run[c]) in texts for c, texts in wanted.items()))
            if runs:
                found.append(setting if len(runs) == len(setting.runs) else replace(setting, runs=runs))
    return found


def one_setting(results: Results, experiment: str, where: Where) -> Setting:
    """Find the one setting that a selector means, the paper's own protocol first. Raises NotRunError."""
    found = settings(results, experiment, where)
    if len(found) > 1:
        found = [setting for setting in found if setting.literal] or found
    if not found:
        raise NotRunError(_why_not_run(results, experiment, where))
    if len(found) > 1:
        raise NotRunError(f"{_spelled(where)} in {experiment} is ambiguous: its settings differ in {_varying(found)}")
    return found[0]


def like_for_like(results: Results, experiment: str, where: Where, against: Where) -> tuple[Setting, Setting]:
    """Find the two settings to compare: they agree in every card column that neither selector names.

    `literal` says how a run relates to the paper, not what was run, and need not agree. Of several pairs the one of the
    longest budget is meant. Raises NotRunError.
    """
    ours, others = settings(results, experiment, where), settings(results, experiment, against)
    if not ours or not others:
        raise NotRunError(_why_not_run(results, experiment, where if not ours else against))
    shared = [column for column in CARD if column not in {*where, *against, "literal"}]
    pairs = [(a, b) for a in ours for b in others if all(_same(a, b, column) for column in shared)]
    if not pairs:
        raise NotRunError(f"{experiment} has no like-for-like pair: the settings differ in {_varying(ours + others)}")
    longest = max(_budget(a) for a, _ in pairs)
    pairs = [(a, b) for a, b in pairs if _budget(a) == longest]
    if len(pairs) > 1:
        choices = _varying([a for a, _ in pairs])
        raise NotRunError(f"{experiment} has several like-for-like pairs: name one of {choices}")
    return pairs[0]


def paired_values(ours: Setting, other: Setting, metric: str) -> tuple[np.ndarray, np.ndarray]:
    """Return both settings' values, (pair,), for the seeds that they share."""
    first = dict(zip(ours.members, ours.values(metric), strict=False))
    second = dict(zip(other.members, other.values(metric), strict=False))
    seeds = [seed for seed in first if seed in second]
    return np.array([first[seed] for seed in seeds]), np.array([second[seed] for seed in seeds])


def anchor(results: Results, experiment: str, name: str, test_set: Mapping[str, Any]) -> Setting | None:
    """Find an anchor judged on the same test set: of this experiment first, from clean labels first."""
    for place in (experiment, None):
        found = [s for s in settings(results, place, ANCHORS[name]) if test_set_of(s.card) == test_set]
        if found:
            return min(found, key=_uncleanness)
    return None


def test_set_of(card: Mapping[str, Any]) -> dict[str, Any]:
    """Return the card columns that decide the test set; one long trajectory has no episodes."""
    return {c: card[c] for c in TEST_SET if not (c == "episode_steps" and card["regime"] == "long")}


def anchor_name(setting: Setting) -> str | None:
    """Say which anchor a setting is, if any."""
    for name, where in ANCHORS.items():
        if all(
            setting.card[column] in (value if isinstance(value, list) else [value]) for column, value in where.items()
        ):
            return name
    return None


def varying_columns(found: Sequence[Setting]) -> list[str]:
    """List the card columns in which settings differ."""
    return [column for column in CARD if len({as_text(setting.card[column]) for setting in found}) > 1]


def _runs_with(results: Results, experiment: str | None, where: Where) -> "pd.DataFrame":
    chosen = results.runs[results.runs["setting"] != ""]
    if experiment is not None:
        chosen = chosen[chosen["experiment"] == experiment]
    for column, wanted in where.items():
        agrees = np.array([as_text(plain(value)) in _texts(wanted) for value in chosen[column]], dtype=bool)
        chosen = chosen[agrees]
    return chosen


def _texts(wanted: Any) -> set[str]:
    return {as_text(value) for value in (wanted if isinstance(wanted, list) else [wanted])}


def _why_not_run(results: Results, experiment: str, where: Where) -> str:
    died = _runs_with(results, experiment, where)
    if len(died):
        return f"{died['run'].iloc[0]} {died['outcome'].iloc[0]}: {died['error'].iloc[0]}"
    return f"no run of {experiment} with {_spelled(where)}"


def _budget(setting: Setting) -> int:
    return setting.card["epochs"] or 0


def _uncleanness(setting: Setting) -> tuple[bool, float, float, int]:
    """Order by noise, and among equals the one that has learned from most comes first."""
    card = setting.card
    return card["labels"] != "exact", card["tau_noise"] or 0.0, card["qdd_noise"] or 0.0, -(card["n_train"] or 0)


def _same(a: Setting, b: Setting, column: str) -> bool:
    return as_text(a.card[column]) == as_text(b.card[column])


def _varying(found: Sequence[Setting]) -> str:
    parts = [
        f"{column} ({', '.join(sorted({as_text(setting.card[column]) or 'none' for setting in found}))})"
        for column in varying_columns(found)
    ]
    return "; ".join(parts) or "their overrides"


def _spelled(where: Where) -> str:
    return ", ".join(f"{column}={as_text(value)}" for column, value in where.items()) or "any card"
