"""Finished runs in an MLflow tracking store, for those who compare their experiments there.

The store of this project stays the one that counts: a copy is never read back, and a run that MLflow already has is
left as it is.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from datetime import datetime
from importlib import import_module
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking import index, record
from repro.tracking.paths import RUN_FILE, Paths, outputs_root
from repro.tracking.record import Record

TAG = "repro.run"
_LONGEST = 6000  # characters that MLflow takes as the value of a parameter


def main(argv: Sequence[str]) -> int:
    """`repro mlflow URI key=value ...`: copy finished runs to an MLflow tracking store."""
    parser = argparse.ArgumentParser(
        prog="repro mlflow",
        description="Copy finished runs to an MLflow tracking store: card, medians and tables. Runs there are left.",
        epilog="example: repro mlflow sqlite:///mlflow.db model=lagrangian basis=t2",
    )
    parser.add_argument("uri", help="where MLflow keeps its runs: sqlite:///mlflow.db, http://host:5000, ...")
    parser.add_argument("filters", nargs="*", metavar="key=value", help="only runs whose card says so")
    parser.add_argument("--experiment", default="repro", help="experiment of MLflow that takes the runs")
    options = parser.parse_args(argv)
    for text in options.filters:
        if "=" not in text:
            raise UserError(f"{text} is no filter; write key=value, e.g. model=lagrangian")
    new = export(options.uri, experiment=options.experiment, **dict(text.split("=", 1) for text in options.filters))
    print(f"{len(new)} runs copied to {options.uri}, experiment {options.experiment}")
    return 0


def export(uri: str, *, experiment: str = "repro", root: Path | None = None, **filters: object) -> list[str]:
    """Copy the finished runs whose card says what the filters say; returns the ids of those that are new there.

    Raises UserError when the extra is not installed or the tracking store does not take the runs.
    """
    try:
        mlflow = import_module("mlflow")
    except ModuleNotFoundError as error:
        raise UserError(f"{error.name} is missing: pip install -e '.[mlflow]' in the project's folder") from error
    try:
        client = mlflow.MlflowClient(tracking_uri=uri)
        place = client.get_experiment_by_name(experiment)
        number = place.experiment_id if place else client.create_experiment(experiment)
        new = []
        for entry in _finished(Paths(root or outputs_root()), filters):
            there = f"tags.`{TAG}` = '{entry.id}' and attributes.status = 'FINISHED'"
            if not client.search_runs([number], there, max_results=1):
                _copy(client, number, entry)
                new.append(entry.id)
    except mlflow.exceptions.MlflowException as error:
        raise UserError(f"MLflow at {uri}: {error}") from error
    return new


def _finished(paths: Paths, filters: Mapping[str, object]) -> list[Record]:
    entries = [entry for entry in index.load(paths).finished().values() if entry.kind == "runs"]
    cards = {entry.id: entry.card for entry in entries}
    chosen = [id for id, card in cards.items() if all(_fits(card.get(key), wish) for key, wish in filters.items())]
    return [record.read(paths.folder("runs", id)) for id in chosen]


def _fits(value: object, wish: object) -> bool:
    return str(value).lower() == str(wish).lower()


def _copy(client: Any, experiment: str, run: Record) -> None:
    origin = run.provenance
    tags = {TAG: run.id, "command": origin.command, "mlflow.runName": run.id}
    copy = client.create_run(experiment, start_time=_milliseconds(origin.started), tags=tags).info.run_id
    for name, value in run.summary["card"].items():
        text = value if isinstance(value, str) else json.dumps(value)
        client.log_param(copy, name, text[:_LONGEST])
    for name, value in run.summary["median"].items():
        if value is not None and math.isfinite(value):
            client.log_metric(copy, _metric(name), value)
    for name in (*run.files, RUN_FILE):
        client.log_artifact(copy, os.fspath(run.path(name)))
    client.set_terminated(copy, end_time=_milliseconds(origin.finished))


def _metric(name: str) -> str:
    """A metric's name in the letters that MLflow allows: mae_tau[0] becomes mae_tau/0."""
    return re.sub(r"[^\w\-./ ]", "", name.replace("[", "/"))


def _milliseconds(time: str) -> int:
    return round(datetime.fromisoformat(time).timestamp() * 1000)
