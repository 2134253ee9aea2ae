"""From a selector to the settings it means; which settings may be compared; the anchors of a test set."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from repro.results.columns import LOOP
from repro.results.results import Results
from repro.results.run_card import OPTIONS, spelled
from repro.results.run_setting import RunSetting
from repro.results.table_schema import CARD, LOOP_CARD, TEST_SET, Row, as_text, cell_text
from repro.tracking.lazy_pandas import pd

Where = Mapping[str, object]

TRIVIAL, DEGENERATE, ORACLE = "trivial", "degenerate", "oracle"
ANCHORS: Mapping[str, Where] = {
    TRIVIAL: {"model": "trivial"},
    DEGENERATE: {"model": "degenerate"},
    ORACLE: {"basis": ["t1", "fxf"], "optimiser": "least_squares", "sequence": "main"},
}
# Settings that are drawn, or vary from loop to loop, within what counts as one setting.
DRAWN = ("x_des", "starts", "start_seed", "seeds")


class NotRunError(Exception):
    """No stored run answers the question: the message says which was looked for."""


class AmbiguousError(NotRunError):
    """Several settings answer the question: the message says what they differ in."""


def settings(results: Results, experiment: str | None, where: Where | None = None) -> list[RunSetting]:
    """The settings of an experiment (None: of all) with `where`: column or dotted key -> value, or list of values."""
    return [
        setting
        for setting in results.settings
        if experiment in (None, setting.rows[0]["experiment"]) and agrees(setting.text, where or {})
    ]


def agrees(text: Callable[[str], str], where: Where) -> bool:
    """Whether the texts by name are those of a selector."""
    return all(text(name) in _texts(value) for name, value in where.items())


def find_loops(results: Results, experiment: str, where: Where) -> "pd.DataFrame":
    """The closed loops of an experiment that agree with `where`: columns of `control`, or dotted keys."""
    loops = results.loops.get(experiment, results.control.iloc[:0])
    meant = np.ones(len(loops), dtype=bool)
    for name, value in where.items():
        wanted = _texts(value)
        places, kinds = loops["run" if "." in name else name].factorize(use_na_sentinel=False)
        cells = [results.configs[run].get(name) for run in kinds] if "." in name else kinds
        meant &= np.array([cell_text(cell) in wanted for cell in cells], dtype=bool)[places]
    return loops[meant]


def loops_of_one_setting(results: Results, experiment: str, where: Where) -> "pd.DataFrame":
    """The closed loops of a selector. AmbiguousError where they differ in more than what is drawn or listed in it."""
    loops = find_loops(results, experiment, where)
    named = {name for name, value in where.items() if isinstance(value, list)}
    compared = [column for column in LOOP_CARD if column not in {*named, OPTIONS}]
    texts = {column: set(map(cell_text, loops[column].unique())) for column in compared}
    differing = _differing(texts)
    if not differing:  # in a column, but perhaps in settings that no column shows
        configs = [results.configs.get(run, {}) for run in loops["run"].unique()]
        aside = {*named, *(key for name in named if name in LOOP for key in LOOP[name].keys)}
        keys = sorted({key for config in configs for key in config} - aside)
        keys = [key for key in keys if key.rpartition(".")[2] not in DRAWN]
        differing = [key for key in keys if len({as_text(config.get(key)) for config in configs}) > 1]
    if differing:
        raise AmbiguousError(f"closed loops of {experiment} with {in_words(where)} differ in {'; '.join(differing)}")
    return loops


def one_setting(results: Results, experiment: str, where: Where) -> RunSetting:
    """Find the one setting that a selector means, the paper's own protocol first. Raises NotRunError."""
    found = settings(results, experiment, where)
    if len(found) > 1:
        found = [setting for setting in found if setting.as_printed] or found
    if not found:
        raise NotRunError(_why_not_run(results, experiment, where))
    if len(found) > 1:
        raise AmbiguousError(
            f"{in_words(where)} in {experiment} is ambiguous: its settings differ in {_varying(found)}"
        )
    return found[0]


def like_for_like(results: Results, experiment: str, where: Where, against: Where) -> tuple[RunSetting, RunSetting]:
    """The two settings to compare, alike in all that no selector names, of the longest budget. Raises NotRunError."""
    ours, others = settings(results, experiment, where), settings(results, experiment, against)
    if not ours or not others:
        raise NotRunError(_why_not_run(results, experiment, where if not ours else against))
    pairs = [(a, b) for a in ours for b in others if alike(a, b, named={*where, *against})]
    if not pairs:
        raise NotRunError(f"{experiment} has no like-for-like pair: the settings differ in {_varying(ours + others)}")
    longest = max(a.card["epochs"] or 0 for a, _ in pairs)
    pairs = [(a, b) for a, b in pairs if (a.card["epochs"] or 0) == longest]
    if len(pairs) > 1:
        choices = _varying([a for a, _ in pairs])
        raise AmbiguousError(f"{experiment} has several like-for-like pairs: name one of {choices}")
    return pairs[0]


def alike(a: RunSetting, b: RunSetting, named: Collection[str] = ()) -> bool:
    """Whether two settings agree in every card column and in every option, those that are `named` aside.

    `as_printed` says how a run relates to the paper, not what was run, and need not agree. Options of a group are
    compared only where both runs chose the same of that group: the options of two optimisers have nothing in common.
    """
    if any(a.text(column) != b.text(column) for column in CARD if column not in {*named, OPTIONS, "as_printed"}):
        return False
    if OPTIONS in named:
        return True
    keys = {key for key in (*a.options, *b.options) if key not in named and _same_choice(a, b, key.partition(".")[0])}
    return all(as_text(a.options.get(key)) == as_text(b.options.get(key)) for key in keys)


def _same_choice(a: RunSetting, b: RunSetting, group: str) -> bool:
    return all(a.text(f"{group}.{key}") == b.text(f"{group}.{key}") for key in ("kind", "name"))


def paired_values(ours: RunSetting, other: RunSetting, metric: str) -> tuple[np.ndarray, np.ndarray]:
    """Return both settings' values, (pair,), for the seeds that they share."""
    first = dict(zip(ours.members, ours.values(metric), strict=False))
    second = dict(zip(other.members, other.values(metric), strict=False))
    seeds = [seed for seed in first if seed in second]
    return np.array([first[seed] for seed in seeds]), np.array([second[seed] for seed in seeds])


def anchor(results: Results, experiment: str, name: str, test_set: Row) -> RunSetting | None:
    """Find an anchor judged on the same test set: of this experiment first, from clean labels first."""
    for place in (experiment, None):
        found = [s for s in settings(results, place, ANCHORS[name]) if test_set_of(s.card) == test_set]
        if found:
            return min(found, key=_uncleanness)
    return None


def test_set_of(card: Row) -> Row:
    """Return the card columns that decide the test set; one long trajectory has no episodes."""
    return {c: card[c] for c in TEST_SET if not (c == "episode_steps" and card["regime"] == "long")}


def anchor_name(setting: RunSetting) -> str | None:
    """Say which anchor a setting is, if any."""
    return next((name for name, where in ANCHORS.items() if agrees(setting.text, where)), None)


def varying_columns(found: Sequence[RunSetting]) -> list[str]:
    """List the card columns in which settings differ."""
    return [column for column in CARD if len({setting.text(column) for setting in found}) > 1]


def with_varying_options(found: Sequence[RunSetting]) -> list[RunSetting]:
    """The same settings, their column `options` without what all others with the same choice in a group have too."""
    return [replace(each, card={**each.card, OPTIONS: _varying_options(each, found)}) for each in found]


def _varying_options(setting: RunSetting, found: Sequence[RunSetting]) -> str:
    def varies(key: str) -> bool:
        group = key.partition(".")[0]
        return any(setting.text(key) != other.text(key) for other in found if _same_choice(setting, other, group))

    own = {key: value for key, value in setting.options.items() if varies(key)}
    return ", ".join(spelled(own, setting.settings))


def _texts(wanted: object) -> set[str]:
    return {as_text(value) for value in (wanted if isinstance(wanted, list) else [wanted])}


def _why_not_run(results: Results, experiment: str, where: Where) -> str:
    for one in results.unfinished:
        run = one.rows[0]
        if run["experiment"] == experiment and agrees(one.text, where):
            return f"{run['run']} {run['outcome']}: {run['error']}"
    return f"no run of {experiment} with {in_words(where)}"


def _uncleanness(setting: RunSetting) -> tuple[bool, float, float, int]:
    """Order by noise, and among equals the one that has learned from most comes first."""
    card = setting.card
    return card["labels"] != "exact", card["tau_noise"] or 0.0, card["qdd_noise"] or 0.0, -(card["n_train"] or 0)


def _varying(found: Sequence[RunSetting]) -> str:
    texts = {column: {setting.text(column) or "none" for setting in found} for column in CARD}
    return "; ".join(_differing(texts)) or "their overrides"


def _differing(texts: Mapping[str, Collection[str]]) -> list[str]:
    return [f"{column} ({', '.join(sorted(found))})" for column, found in texts.items() if len(found) > 1]


def in_words(where: Where) -> str:
    """Spell a selector for a message."""
    return ", ".join(f"{column}={as_text(value)}" for column, value in where.items()) or "any card"
