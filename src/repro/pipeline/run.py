"""One run, done: every stage that is not stored yet, in order."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from repro.config.schema import Config
from repro.pipeline.plan import Pipeline
from repro.pipeline.work import Work
from repro.tracking import progress
from repro.tracking.record import Record
from repro.tracking.store import Store


def execute(pipeline: Pipeline, store: Store) -> Record:
    """Make whatever is not there yet, and return the run's record; StageFailed when a stage fails."""
    for part in pipeline.part_pipelines:
        execute(part, store)
    work = Work(pipeline, store)
    for role, stage in pipeline.data_stages.items():
        progress.report(0.0, f"data: {role}")
        store.compute(stage, partial(work.make_data, role=role))
    fit = store.compute(pipeline.fit_stage, work.make_fit)
    closed = None
    if pipeline.control_stage is not None:
        closed = store.compute(pipeline.control_stage, lambda folder: work.make_control(folder, fit))
    progress.report(0.95, "evaluation")
    run = store.compute(pipeline.run_stage, lambda folder: work.make_run(folder, fit, closed))
    if pipeline.is_recorded(run):
        store.compute(pipeline.recording_stage, lambda folder: work.make_recording(folder, run))
    return run


def run_job(resolved: Mapping[str, Any], outputs: str, command: str, overrides: Sequence[str] = ()) -> dict[str, Any]:
    """The target of a sweep's jobs: run one configuration; returns the run's id and its median metrics."""
    import torch

    torch.set_num_threads(1)
    pipeline = Pipeline.of(Config.model_validate(resolved), command)
    record = execute(pipeline, Store(Path(outputs), overrides))
    return {"run": record.id, "median": record.summary["median"]}
