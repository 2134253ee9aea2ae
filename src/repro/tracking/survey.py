"""The state of every stage (done, stale, failed, missing, running, interrupted, damaged) and the reasons."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from typing import Any

from repro.errors import UserError
from repro.tracking import code, index, lock
from repro.tracking.experiment_list import ExperimentList, ListedJob, experiment_lists
from repro.tracking.index import Index
from repro.tracking.paths import HOLDER_FILE, WORK, Paths
from repro.tracking.record import Identity, StageOutcome, read
from repro.tracking.stage import Stage
from repro.tracking.stage_difference import identity_differences
from repro.tracking.store import Store


class StageState(StrEnum):
    """What a stage in the store, or a run that an experiment lists, is worth now."""

    DONE = "done"
    STALE = "stale"
    FAILED = "failed"
    MISSING = "missing"
    RUNNING = "running"
    INTERRUPTED = "interrupted"
    DAMAGED = "damaged"


STATES = tuple(StageState)
_STATE_OF = {StageOutcome.FAILED: StageState.FAILED, StageOutcome.DAMAGED: StageState.DAMAGED}
# Separates a change from the upstream stage in which it happened.
_UPSTREAM = " (upstream "
RUNS = "runs"
# The kind of the stages upstream of a run, by their role; all others are data.
KIND_OF_ROLE = {"fit": "fits", "control": "control"}
# Overrides of a job -> the stages it consists of by the present defaults and code, the run itself last.
Expected = Callable[[Sequence[str]], Sequence[Stage]]
# Experiment -> a digest of all that the settings of its jobs depend on.
SettingsDigest = Callable[[str], str]


@dataclass(frozen=True)
class Item:
    """State of one stage, with the reasons as readable lines and the command that makes it."""

    id: str
    kind: str
    name: str
    state: StageState
    why: tuple[str, ...] = ()
    command: str = ""
    experiments: tuple[str, ...] = ()


def survey(
    paths: Paths, *, verify: bool = False, expected: Expected | None = None, settings: SettingsDigest | None = None
) -> list[Item]:
    """The state of every stage in the store and of every run that an experiment lists.

    A finished stage is stale when the code, the libraries or an upstream stage no longer give its identity; with
    `expected`, also when the defaults no longer do, which is not checked for an experiment that was listed under the
    present digest of its `settings`. `verify` reads every byte of every finished stage and moves damaged ones aside.
    """
    stored = index.load(paths)
    changes = _changes(stored)
    listed: dict[str, list[tuple[ExperimentList, ListedJob]]] = {}
    for each in experiment_lists(paths):
        for job in each.jobs:
            # A job that has not reached its run has no id yet; its command takes the place of the id.
            listed.setdefault(job.run or job.command, []).append((each, job))
    known: dict[StageOutcome, list[Item]] = {outcome: [] for outcome in StageOutcome}
    for entry in stored.entries:
        why = changes(entry.id) if entry.outcome is StageOutcome.OK else (entry.error,)
        state = _STATE_OF.get(entry.outcome, StageState.STALE if why else StageState.DONE)
        known[entry.outcome].append(Item(entry.id, entry.kind, entry.name, state, why, entry.command))
    # Of one id the last counts.
    layers = known[StageOutcome.FAILED], _deleted(stored), _being_made(paths), known[StageOutcome.OK]
    items = {item.id: item for layer in (*layers, known[StageOutcome.DAMAGED]) for item in layer}
    for id, jobs in listed.items():
        first_list, first = jobs[0]
        item = items.get(id, Item(id, RUNS, id, StageState.MISSING, ("not made yet",), first.command))
        current = settings is not None and settings(first_list.experiment) == first_list.settings
        # A listing without overrides (the benchmark) is made by no configuration, so no default can outdate it.
        unsure = first.overrides and not current
        outdated = _outdated(item, first.overrides, stored, paths, expected) if expected and unsure else ()
        state = StageState.STALE if outdated and item.state is StageState.DONE else item.state
        experiments = tuple(sorted({f"{each.scale}/{each.experiment}" for each, _ in jobs}))
        items[id] = replace(item, state=state, why=item.why + outdated, experiments=experiments)
    finished = [item for item in items.values() if item.state in (StageState.DONE, StageState.STALE)]
    for item in finished if verify else ():
        if damage := Store(paths.root).verify(item.kind, item.id):
            why = (f"{damage}; moved aside, its command makes it again",)
            items[item.id] = replace(item, state=StageState.DAMAGED, why=why)
    return sorted(items.values(), key=lambda item: (item.kind, STATES.index(item.state), item.id))


def _deleted(stored: Index) -> Iterator[Item]:
    """The stages that a run was made from and that are not stored any more; the run's command makes them again."""
    finished = stored.finished()
    for run in (entry for entry in finished.values() if entry.kind == RUNS):
        for role, id in run.upstream.items():
            if id not in finished:
                why = (f"deleted; {run.id} was made from it",)
                yield Item(id, KIND_OF_ROLE.get(role, "data"), id, StageState.MISSING, why, run.command)


def _changes(stored: Index) -> Callable[[str], tuple[str, ...]]:
    """By id of a finished stage: what has changed in code, libraries and upstream stages since it was made."""
    entries = stored.finished()
    changed_code = cache(lambda key: _code_reasons(stored.codes[key]))

    @cache
    def why(id: str) -> tuple[str, ...]:
        # An upstream stage that was removed is no reason: its id identifies it, and it can be made again.
        reasons = [
            reason if _UPSTREAM in reason else f"{reason}{_UPSTREAM}{role} {source})"
            for role, source in entries[id].upstream.items()
            if source in entries
            for reason in why(source)
        ]
        return (*changed_code(entries[id].code), *dict.fromkeys(reasons))

    return why


def _code_reasons(stored: Mapping[str, Any]) -> tuple[str, ...]:
    before = Identity(code=stored["code"], libraries=stored["libraries"])
    try:
        after = code.closure(tuple(stored["modules"]))
    except UserError as error:
        return (str(error),)
    return tuple(str(difference) for difference in identity_differences(before, after))


def _being_made(paths: Paths) -> Iterator[Item]:
    for kind in paths.kinds():
        for id in paths.ids(kind, WORK):
            holder = paths.folder(kind, id, WORK) / HOLDER_FILE
            try:
                content = json.loads(holder.read_bytes())
            except (OSError, ValueError):
                content = {}
            running = lock.is_held(paths.lock(kind, id))
            maker = lock.holder_text(holder)
            why = [f"{maker} is making it" if running else f"{maker} was ended; its command continues from there"]
            why += [f"log: {content['log']}"] if content.get("log") else []
            state = StageState.RUNNING if running else StageState.INTERRUPTED
            yield Item(id, kind, content.get("name", id), state, tuple(why), content.get("command", ""))


def _outdated(item: Item, overrides: Sequence[str], stored: Index, paths: Paths, expected: Expected) -> tuple[str, ...]:
    """How the run that the present defaults give differs from the listed one."""
    try:
        stages = expected(overrides)
    except UserError as error:
        return (f"its settings are no longer accepted: {error}",)
    if not stages or stages[-1].id == item.id:
        return ()
    reasons: list[str] = []
    finished = stored.finished()
    by_id = {stage.id: stage for stage in stages}
    pairs = [(item.id, stages[-1])]
    while pairs:
        id, stage = pairs.pop()
        if id == stage.id or id not in finished:
            continue
        before = read(paths.folder(finished[id].kind, id)).identity
        differences = identity_differences(before, stage.identity)
        reasons += [str(one) for one in differences if one.area == "config"]
        upstream = [(before.upstream.get(role), id) for role, id in stage.upstream.items()]
        pairs += [(old, by_id[new]) for old, new in upstream if old is not None and new in by_id]
    return tuple(reasons)
