"""Copies of finished runs in an MLflow tracking store, never read back: this project's store holds the results."""

import json
import math
import os
import re
from collections.abc import Iterable
from datetime import datetime
from typing import TYPE_CHECKING

from repro.errors import UserError
from repro.tracking.paths import RUN_FILE
from repro.tracking.record import Record

if TYPE_CHECKING:
    from mlflow import MlflowClient

TAG = "repro.run"
_LONGEST = 6000  # characters that MLflow takes as the value of a parameter


def copy_runs(runs: Iterable[Record], uri: str, experiment: str = "repro") -> list[str]:
    """Copy each run that the experiment lacks; their ids. UserError without the extra, or where the store refuses."""
    try:
        import mlflow
    except ModuleNotFoundError as error:
        raise UserError(f"{error.name} is missing: pip install -e '.[mlflow]' in the project's folder") from error
    try:
        client = mlflow.MlflowClient(tracking_uri=uri)
        existing = client.get_experiment_by_name(experiment)
        number = existing.experiment_id if existing else client.create_experiment(experiment)
        copied = []
        for run in runs:
            same = f"tags.`{TAG}` = '{run.id}' and attributes.status = 'FINISHED'"
            if not client.search_runs([number], same, max_results=1):
                _copy(client, number, run)
                copied.append(run.id)
    except mlflow.exceptions.MlflowException as error:
        raise UserError(f"MLflow at {uri}: {error}") from error
    return copied


def _copy(client: "MlflowClient", experiment: str, run: Record) -> None:
    """Card as parameters, medians as metrics, tables and run.json as artifacts."""
    origin = run.provenance
    tags = {TAG: run.id, "command": origin.command, "mlflow.runName": run.id}
    copy = client.create_run(experiment, start_time=_milliseconds(origin.started), tags=tags).info.run_id
    for name, value in run.summary["card"].items():
        text = value if isinstance(value, str) else json.dumps(value)
        client.log_param(copy, name, text[:_LONGEST])
    for name, value in run.summary["median"].items():
        if value is not None and math.isfinite(value):
            allowed = re.sub(r"[^\w\-./ ]", "", name.replace("[", "/"))  # mae_tau[0] becomes mae_tau/0
            client.log_metric(copy, allowed, value)
    for name in (*run.files, RUN_FILE):
        client.log_artifact(copy, os.fspath(run.path(name)))
    client.set_terminated(copy, end_time=_milliseconds(origin.finished))


def _milliseconds(time: str) -> int:
    return round(datetime.fromisoformat(time).timestamp() * 1000)
