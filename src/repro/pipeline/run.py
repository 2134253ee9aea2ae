"""One run, done: every stage that is not stored yet, in order."""

import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from repro.config.schema import Config
from repro.pipeline.card import summary_of
from repro.pipeline.plan import PRETRAINING, Pipeline
from repro.pipeline.stages import close_loops, data, evaluate, fit
from repro.plugins.plugin import plugin
from repro.tracking import progress
from repro.tracking.load import Run, load_run
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
    made = {*pipeline.data_stages, PRETRAINING}
    parts = {role: id for role, id in pipeline.fit_stage.upstream.items() if role not in made}
    upstream = {role: load_run(id, root=store.paths.root) for role, id in parts.items()}
    for role, stage in pipeline.data_stages.items():
        progress.report(0.0, f"data: {role}")
        upstream[role] = Run(_done(store, stage, partial(data.make, options=pipeline.data_options[role])))
    if (options := pipeline.pretraining_options) is not None and (begun := pipeline.pretraining_stage) is not None:
        used = {role: upstream[role] for role in begun.upstream}
        work = partial(fit.make, options=options, upstream=used, beginning=True)
        upstream[PRETRAINING] = Run(_done(store, begun, work))
    fitted = _done(store, pipeline.fit_stage, partial(fit.make, options=pipeline.fit_options, upstream=upstream))
    inputs = {"fit": Run(fitted)}
    if pipeline.control_stage is not None:
        work = partial(close_loops.make, options=pipeline.loop_options, upstream=inputs)
        inputs["control"] = Run(_done(store, pipeline.control_stage, work))
    progress.report(0.95, "evaluation")

    def measured(folder: Path) -> Json:
        summary = evaluate.make(folder, pipeline.run_options, inputs)
        n_train = upstream["data"].record.summary["n_train"]
        counted = {name: fitted.summary[name] for name in ("n_parameters", "status", "notes")}
        sha256 = pipeline.data_options["data"].sha256
        before = [*upstream.values(), *inputs.values()]
        notices = [text for stage in before for text in stage.record.summary.get(NOTICES, ())]
        return summary | summary_of(pipeline.config, n_train=n_train, sha256=sha256, **counted) | {NOTICES: notices}

    run = store.compute(pipeline.run_stage, measured)
    if pipeline.is_recorded(run):
        record = plugin("pipeline.stages", pipeline.recording_kind).make
        work = partial(record, options=pipeline.recording_options, run=Run(run), command=pipeline.command)
        store.compute(pipeline.recording_stage, work)
    return run


def _done(store: Store, stage: Stage, work: Callable[[Path], Json]) -> Record:
    """The stage, stored or made now; what was said when a stored one was made is said again."""
    stored = store.find(stage.id, kind=stage.kind)
    for text in stored.summary.get(NOTICES, ()) if stored else ():
        progress.notice(text)
    return stored or store.compute(stage, work)


def run_job(resolved: Json, outputs: str, command: str, overrides: Sequence[str] = ()) -> Json:
    """The target of a sweep's jobs: run one configuration; returns the run's id and its median metrics."""
    os.environ["OMP_NUM_THREADS"] = "1"  # of torch where a model loads it later
    if (torch := sys.modules.get("torch")) is not None:
        torch.set_num_threads(1)
    pipeline = Pipeline.of(Config.model_validate(resolved), command)
    record = execute(pipeline, Store(Path(outputs), overrides))
    return {"run": record.id, "median": record.summary["median"]}
