"""`repro mlflow`: copies finished runs to an MLflow tracking store."""

from collections.abc import Sequence

from repro.commands.arguments import add_filters, check_known, command_parser, filters, fits
from repro.export.mlflow_runs import copy_runs
from repro.tracking import index, record
from repro.tracking.paths import Paths, outputs_root


def main(argv: Sequence[str]) -> int:
    """Copy the runs with these values on their card."""
    description = "Copy finished runs to an MLflow tracking store: card, medians and tables. Copies there are kept."
    example = "example: repro mlflow sqlite:///mlflow.db model=lagrangian basis=t2"
    parser = command_parser("mlflow", description, example)
    parser.add_argument("uri", help="where MLflow keeps its runs: sqlite:///mlflow.db, http://host:5000, ...")
    add_filters(parser)
    parser.add_argument("--experiment", default="repro", help="experiment of MLflow that takes the runs")
    arguments = parser.parse_args(argv)
    values = filters(arguments.filters)
    paths = Paths(outputs_root())
    entries = [entry for entry in index.load(paths).finished().values() if entry.kind == "runs"]
    check_known(values, [entry.card for entry in entries])
    runs = (record.read(paths.folder("runs", entry.id)) for entry in entries if fits(entry.card, values))
    copied = copy_runs(runs, arguments.uri, arguments.experiment)
    print(f"{len(copied)} runs copied to {arguments.uri}, experiment {arguments.experiment}")
    return 0
