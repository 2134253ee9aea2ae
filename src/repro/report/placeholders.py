"""Placeholders of the report's texts (jinja2), filled from stored results: no number of ours is ever typed.

{{ claim.C4a }}                   ours, its unit and the verdict: 0.131 [0.105, 0.191] N, N m (consistent)
{{ claim.C4a.ours }}              also .median .low .high .members .failed .printed .verdict .flag .note .cure
{% if claim.C4a.consistent %} ... {% endif %}   text for a verdict: .supported .undecided .not_run and so on, joined by
                                  and, or; .holds: supported, with changes or by construction; .fails: not supported
{{ claims() }}                    how many claims there are, and how many of each class: 24 claims: 8 supported, ...
{{ metric("EXPERIMENT", "METRIC", c=v) }}   a metric, with its interval, of the one setting whose card columns agree
{{ ratio("EXPERIMENT", "METRIC", {"c": v}, {"c": w}) }}   of the first setting over the second, seed by seed
{{ loops("EXPERIMENT", c=v) }}    closed loops that succeed: 9 of 10
{{ runs() }}, {{ runs("EXPERIMENT") }}      finished runs
{{ cost("cpu_hours") }}           processor time and machine, see tables/cost.py

A result that is missing reads "not run"; a selector that means several settings reads "ambiguous".
"""

import re
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, TemplateError

from repro.claims.verdict_kind import VerdictClass, VerdictKind
from repro.claims.verdicts import Verdict, headline
from repro.errors import UserError
from repro.report import writing
from repro.report.tables.cost import cost_fact
from repro.report.tables.verdicts import in_words
from repro.results.results import Results
from repro.results.selectors import AmbiguousError, NotRunError, loops_of_one_setting, one_setting, paired_values
from repro.results.statistics import paired_ratio
from repro.results.table_schema import CARD, TABLES

NOT_RUN = VerdictKind.NOT_RUN
AMBIGUOUS = "ambiguous"
MEASURED = ("short", "ours", "median", "low", "high", "members", "failed")
HOLDS = (VerdictClass.SUPPORTED, VerdictClass.WITH_CHANGES, VerdictClass.BY_CONSTRUCTION)


class Texts:
    """The texts in a folder, their placeholders filled from results and verdicts; the result is Markdown."""

    def __init__(self, folder: Path, results: Results, verdicts: Sequence[Verdict]) -> None:
        self.folder = folder
        self._environment = Environment(
            loader=FileSystemLoader(folder),
            undefined=StrictUndefined,
            finalize=lambda value: writing.markdown(str(value)),
            trim_blocks=True,
            autoescape=False,
        )
        claims = {verdict.claim.name: _Claim(_facts(verdict)) for verdict in verdicts}
        self._environment.globals |= {"claims": lambda: headline(verdicts), "claim": claims, **_functions(results)}

    def names(self, folder: str) -> list[str]:
        """Return the names of the texts in a folder, sorted: texts/abstract.md."""
        return [f"{folder}/{path.name}" for path in sorted((self.folder / folder).glob("*.md"))]

    def fill(self, name: str) -> str:
        """Return one file as text. Raises UserError naming file and line for a placeholder that means nothing."""
        try:
            text = self._environment.get_template(name).render()
        except (TemplateError, TypeError, ValueError) as error:
            raise UserError(f"{self.folder / name}, line {_line(error, name)}: {error}; see {__name__}") from error
        return re.sub(r"\n\s*\n\s*\n", "\n\n", text).strip()


def _functions(results: Results) -> dict[str, Callable[..., str]]:
    """What a text can call, by name, see the head of this file."""

    def metric(experiment: str, metric: str, **where: Any) -> str:
        estimate = one_setting(results, experiment, _checked(where, CARD)).estimate(metric)
        return writing.interval(estimate) if estimate.n else NOT_RUN

    def ratio(experiment: str, metric: str, ours: Mapping[str, Any], other: Mapping[str, Any]) -> str:
        first, second = (one_setting(results, experiment, _checked(where, CARD)) for where in (ours, other))
        ratio = paired_ratio(*paired_values(first, second, metric))
        return writing.interval(ratio) if ratio.n else NOT_RUN

    def loops(experiment: str, **where: Any) -> str:
        loops = loops_of_one_setting(results, experiment, _checked(where, TABLES["control"]))
        return f"{int(loops['success'].sum())} of {len(loops)}" if len(loops) else NOT_RUN

    def runs(*experiments: str) -> str:
        finished = results.runs[results.runs["outcome"] == "ok"]
        if experiments:
            finished = finished[finished["experiment"].isin(experiments)]
        return str(finished["run"].nunique() or NOT_RUN)

    functions: dict[str, Callable[..., str]] = {"cost": partial(cost_fact, results)}
    functions |= {"metric": metric, "ratio": ratio, "loops": loops, "runs": runs}
    return {name: _or_not_run(read) for name, read in functions.items()}


class _Claim(dict[str, "str | bool"]):
    """What can be written of a claim, by name; alone it is written in short."""

    def __str__(self) -> str:
        return str(self["short"])


def _facts(verdict: Verdict) -> dict[str, str | bool]:
    unit = "" if verdict.unit in ("", "1") else f" {verdict.unit.replace('^2', '²')}"
    shown = in_words(verdict)
    shown["short"] = f"{shown['ours']}{unit} ({verdict.verdict})"
    return {
        **shown,
        **({} if verdict.estimate.n else dict.fromkeys(MEASURED, NOT_RUN)),
        "flag": verdict.flag or "no anchor reaches it",
        "cure": shown["cure"] or "none is known",
        "holds": verdict.counted_as in HOLDS,
        "fails": verdict.counted_as is VerdictClass.NOT_SUPPORTED,
        **{re.sub(r"\W", "_", name): verdict.verdict == name for name in VerdictKind},
        "not_run": not verdict.estimate.n,
    }


def _or_not_run(read: Callable[..., str]) -> Callable[..., str]:
    def answered(*arguments: Any, **where: Any) -> str:
        try:
            return read(*arguments, **where)
        except AmbiguousError:
            return AMBIGUOUS
        except NotRunError:
            return NOT_RUN

    return answered


def _checked(where: Mapping[str, Any], columns: Mapping[str, type]) -> Mapping[str, Any]:
    if unknown := [column for column in where if column not in columns and "." not in column]:
        raise ValueError(f"{', '.join(unknown)} is no column of the results")
    return where


def _line(error: Exception, name: str) -> int:
    """Return the line of a text at which an error was raised; 0 where it is not known."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename.endswith(name)]
    return getattr(error, "lineno", None) or (frames[-1].lineno if frames else None) or 0
