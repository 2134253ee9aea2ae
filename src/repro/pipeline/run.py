"""One run, done: every stage that is not stored yet, in order."""

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path

from repro.config.schema import Config
from repro.pipeline.card import summary_of
from repro.pipeline.plan import Pipeline
from repro.tracking import progress
from repro.tracking.load import load_stage
from repro.tracking.plain_data import Json
from repro.tracking.record import Record
from repro.tracking.stage import Stage
from repro.tracking.store import NOTICES, Store


def execute(pipeline: Pipeline, store: Store) -> Record:
    """Make whatever is not stored yet, and return the run's record; StageFailed when a stage fails.

    The work of a stage is handed its options, which are part of its identity, and the stages upstream, nothing else.
    """
    for part in pipeline.part_pipelines:
        execute(part, store)
    made = {id: load_stage(id, root=store.paths.root) for _, id in pipeline.parts}
    for role, stage in pipeline.data_stages.items():
        progress.report(0.0, f"data: {role}")
        made[stage.id] = _done(store, stage, made)
    *before, last = pipeline.stages
    for stage in before[len(pipeline.data_stages) :]:
        made[stage.id] = _done(store, stage, made)
    progress.report(0.95, "evaluation")

    def measured(folder: Path) -> Json:
        data, fit = (made[stage.id] for stage in (pipeline.data_stages["data"], pipeline.fit_stage))
        counted = {name: fit.summary[name] for name in ("n_parameters", "status", "notes")}
        counted |= {"n_train": data.summary["n_train"], "sha256": data.identity.config["sha256"]}
        notices = [text for stage in made.values() for text in stage.summary.get(NOTICES, ())]
        return work_of(last, made)(folder) | summary_of(pipeline.config, **counted) | {NOTICES: notices}

    run = store.compute(last, measured)
    if pipeline.is_recorded(run):
        recording = pipeline.recording_stage
        store.compute(recording, work_of(recording, {run.id: run}))
    return run


def work_of(stage: Stage, made: Mapping[str, Record]) -> Callable[[Path], Json]:
    """What makes a stage: `make(folder, options, upstream)` of the module where its code starts."""
    upstream = {role: made[id] for role, id in stage.upstream.items()}
    return partial(import_module(stage.modules[0]).make, options=stage.config, upstream=upstream)


def _done(store: Store, stage: Stage, made: Mapping[str, Record]) -> Record:
    """The stage, stored or made now; what was said when a stored one was made is said again."""
    stored = store.find(stage.id, kind=stage.kind)
    for text in stored.summary.get(NOTICES, ()) if stored else ():
        progress.notice(text)
    return stored or store.compute(stage, work_of(stage, made))


def run_job(resolved: Json, outputs: str, command: str, overrides: Sequence[str] = ()) -> Json:
    """The target of a sweep's jobs: run one configuration; returns the run's id and its median metrics."""
    os.environ["OMP_NUM_THREADS"] = "1"  # of torch where a model loads it later
    if (torch := sys.modules.get("torch")) is not None:
        torch.set_num_threads(1)
    pipeline = Pipeline.of(Config.model_validate(resolved), command)
    record = execute(pipeline, Store(Path(outputs), overrides))
    return {"run": record.id, "median": record.summary["median"]}
