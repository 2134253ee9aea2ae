"""`repro mlflow`: copies finished runs to an MLflow tracking store."""

from argparse import Namespace

from repro.commands.arguments import selected
from repro.export.mlflow_runs import copy_runs
from repro.tracking import index, record
from repro.tracking.paths import Paths, outputs_root


def main(arguments: Namespace) -> int:
    """Copy the runs with these values on their card."""
    paths = Paths(outputs_root())
    entries = [entry for entry in index.load(paths).finished().values() if entry.kind == "runs"]
    chosen = selected(entries, arguments.filters)
    runs = (record.read(paths.folder("runs", entry.id)) for entry, _ in chosen)
    copied = copy_runs(runs, arguments.uri, arguments.experiment)
    print(f"{len(copied)} runs copied to {arguments.uri}, experiment {arguments.experiment}")
    return 0
