"""`repro mlflow`: copies finished runs to an MLflow tracking store."""

from collections.abc import Sequence

from repro.commands.arguments import add_filters, command_parser, selected
from repro.export.mlflow_runs import copy_runs
from repro.tracking import index, record
from repro.tracking.paths import Paths, outputs_root


def main(argv: Sequence[str]) -> int:
    """Copy the runs with these values on their card."""
    parser = command_parser("mlflow")
    parser.add_argument("uri", help="where MLflow keeps its runs: sqlite:///mlflow.db, http://host:5000, ...")
    add_filters(parser)
    parser.add_argument("--experiment", default="repro", help="experiment of MLflow that takes the runs")
    arguments = parser.parse_args(argv)
    paths = Paths(outputs_root())
    entries = [entry for entry in index.load(paths).finished().values() if entry.kind == "runs"]
    chosen = selected(entries, arguments.filters)
    runs = (record.read(paths.folder("runs", entry.id)) for entry, _ in chosen)
    copied = copy_runs(runs, arguments.uri, arguments.experiment)
    print(f"{len(copied)} runs copied to {arguments.uri}, experiment {arguments.experiment}")
    return 0
