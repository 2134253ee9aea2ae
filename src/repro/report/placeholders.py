"""Placeholders of the report's texts, filled from stored results: no number of ours is ever typed.

{claim.C4a}                       ours, its unit and the verdict: 0.131 [0.105, 0.191] N, N m (better)
{claim.C4a.ours}                  also .median .low .high .members .failed .printed .verdict .flag .note
{metric EXPERIMENT METRIC c=v}    a metric of the one setting whose card columns agree, with its interval
{ratio EXPERIMENT METRIC c=v over c=v}   the ratio of two settings, seed by seed
{loops EXPERIMENT c=v}            closed loops that succeed: 9 of 10
{bench NAME c=v}                  how many times faster ours is, over all rows of that name
{runs}, {runs EXPERIMENT}         finished runs
{claims}, {verdicts}              how many claims there are, and how their verdicts are spread
{cost cpu_hours}                  processor time and machine, see cost.py
{if C4a matched or better, C5a not run}   begins a line: what follows, to the next such line or the end of the
                                  paragraph or item, stands only where all of this holds
"""

import re
import shlex
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import VERDICTS, Verdict
from repro.errors import UserError
from repro.report import writing
from repro.report.tables.cost import cost_fact
from repro.results.results import Results
from repro.results.schema import BENCH, CARD, CONTROL, as_text, plain
from repro.results.selectors import NotRunError, one_setting, paired_values
from repro.results.statistics import paired_ratio

if TYPE_CHECKING:
    import pandas as pd

NOT_RUN = VerdictKind.NOT_RUN
_PLACEHOLDER = re.compile(r"\{([^{}]*)\}")
_GUARD = re.compile(r"(- )?\{if ([^{}]*)\}\s*")
_BREAK = re.compile(r"(\n\s*\n|\n(?=- )|\n(?=\{if ))")


class _UnknownError(Exception):
    """A placeholder that means nothing, or names something that is not there: a mistake in the text."""


def fill(text: str, results: Results, verdicts: Sequence[Verdict], place: str) -> str:
    """Drop what its guard excludes and write a value for every placeholder; the result is Markdown.

    A result that is missing reads "not run". Raises UserError naming `place` for a placeholder that means nothing.
    """
    known = {verdict.claim.name: verdict for verdict in verdicts}

    def value(match: re.Match[str]) -> str:
        return writing.markdown(_value(match[1], results, known))

    try:
        return _PLACEHOLDER.sub(value, _standing(text, known))
    except _UnknownError as fault:
        message = f"{place}: {fault}; see src/repro/report/placeholders.py"
        raise UserError(message) from None


def _standing(text: str, known: Mapping[str, Verdict]) -> str:
    """Leave out every paragraph, item or sentence whose guard does not hold."""
    pieces = _BREAK.split(f"\n\n{text.strip()}")[1:]
    kept, pending = "", ""
    for gap, piece in zip(pieces[::2], pieces[1::2], strict=True):
        pending = max(pending, gap, key=lambda entry: entry.count("\n"))
        guard = _GUARD.match(piece)
        if guard is None or _holds(guard[2], known):
            kept += pending + _GUARD.sub(r"\1", piece, count=1)
            pending = ""
    return kept.strip()


def _holds(condition: str, known: Mapping[str, Verdict]) -> bool:
    """Whether every part holds: `C4a matched or better, C5a not run`."""
    for part in condition.split(","):
        name, _, wanted = part.strip().partition(" ")
        allowed = [verdict.strip() for verdict in wanted.split(" or ")]
        unknown = [verdict for verdict in allowed if verdict not in VERDICTS]
        if unknown:
            raise _UnknownError(f"{{if {condition}}}: {', '.join(unknown)} is no verdict")
        if _claim(name, known).verdict not in allowed:
            return False
    return True


def _value(content: str, results: Results, known: Mapping[str, Verdict]) -> str:
    kind, *words = shlex.split(content) or [""]
    if kind.startswith("claim."):
        return _of_claim(kind.split(".")[1:], known)
    if kind in ("claims", "verdicts"):
        return str(len(known)) if kind == "claims" else _spread(known)
    values = {"metric": _metric, "ratio": _ratio, "loops": _loops, "bench": _bench, "runs": _runs, "cost": _cost}
    if kind not in values:
        raise _UnknownError(f"{{{content}}} is no placeholder")
    try:
        return values[kind](results, words)
    except NotRunError:
        return NOT_RUN
    except ValueError as fault:
        raise _UnknownError(f"{{{content}}}: {fault}") from None


def _claim(name: str, known: Mapping[str, Verdict]) -> Verdict:
    if name not in known:
        raise _UnknownError(f"{name!r} is no claim")
    return known[name]


def _of_claim(path: Sequence[str], known: Mapping[str, Verdict]) -> str:
    readings: Mapping[str, Callable[[Verdict], str]] = {
        "": _in_short,
        "ours": lambda v: writing.interval(v.estimate),
        "median": lambda v: writing.number(v.estimate.median),
        "low": lambda v: writing.number(v.estimate.low),
        "high": lambda v: writing.number(v.estimate.high),
        "members": lambda v: str(v.estimate.n),
        "failed": lambda v: str(v.estimate.failed),
        "printed": lambda v: writing.number(v.claim.printed),
        "verdict": lambda v: v.verdict,
        "flag": lambda v: v.flag or "no anchor reaches it",
        "note": lambda v: v.note,
    }
    name, reading = path if len(path) == 2 else (path[0], "")
    if len(path) > 2 or reading not in readings:
        raise _UnknownError(f"{{claim.{'.'.join(path)}}}: after the claim comes one of {', '.join(readings)}")
    verdict = _claim(name, known)
    measured = reading in ("", "ours", "median", "low", "high", "members", "failed")
    return NOT_RUN if measured and verdict.estimate.n == 0 else readings[reading](verdict)


def _in_short(verdict: Verdict) -> str:
    unit = "" if verdict.unit in ("", "1") else f" {verdict.unit.replace('^2', '²')}"
    return f"{writing.interval(verdict.estimate)}{unit} ({verdict.verdict})"


def _spread(known: Mapping[str, Verdict]) -> str:
    counted = Counter(verdict.verdict for verdict in known.values())
    return ", ".join(f"{counted[name]} {name}" for name in VERDICTS if counted[name])


def _metric(results: Results, words: Sequence[str]) -> str:
    experiment, metric, *selector = words
    found = one_setting(results, experiment, _where(selector, CARD)).estimate(metric)
    return writing.interval(found) if found.n else NOT_RUN


def _ratio(results: Results, words: Sequence[str]) -> str:
    experiment, metric, *selectors = words
    over = selectors.index("over")
    first, second = (
        one_setting(results, experiment, _where(part, CARD)) for part in (selectors[:over], selectors[over + 1 :])
    )
    found = paired_ratio(*paired_values(first, second, metric))
    return writing.interval(found) if found.n else NOT_RUN


def _loops(results: Results, words: Sequence[str]) -> str:
    experiment, *selector = words
    where = _where(selector, CONTROL)
    loops = _rows_with(results.control, {"experiment": experiment, **where})
    return f"{int(loops['success'].sum())} of {len(loops)}" if len(loops) else NOT_RUN


def _bench(results: Results, words: Sequence[str]) -> str:
    name, *selector = words
    where = _where(selector, BENCH)
    rows = _rows_with(results.bench, {"name": name, **where})
    if rows.empty:
        return NOT_RUN
    least, greatest = (writing.number(float(end)) for end in (rows["ratio_median"].min(), rows["ratio_median"].max()))
    return least if least == greatest else f"{least} to {greatest}"


def _runs(results: Results, words: Sequence[str]) -> str:
    finished = results.runs[results.runs["outcome"] == "ok"]
    if words:
        finished = finished[finished["experiment"].isin(words)]
    count = finished["run"].nunique()
    return str(count) if count else NOT_RUN


def _rows_with(table: "pd.DataFrame", where: Mapping[str, str]) -> "pd.DataFrame":
    for column, wanted in where.items():
        table = table[np.array([as_text(plain(value)) == wanted for value in table[column]], dtype=bool)]
    return table


def _cost(results: Results, words: Sequence[str]) -> str:
    (name,) = words
    return cost_fact(results, name)


def _where(selector: Sequence[str], columns: Mapping[str, type]) -> dict[str, str]:
    where = {column: value for column, _, value in (word.partition("=") for word in selector)}
    unknown = [column for column in where if column not in columns]
    if unknown:
        raise ValueError(f"{', '.join(unknown)} is no column here")
    return where
