"""Finished runs in an MLflow tracking store: once each, with card, medians and tables."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from optional import needs_extra

from repro import __main__ as cli
from repro.commands import mlflow
from repro.commands.arguments import parsed
from repro.errors import UserError
from repro.export.mlflow_runs import copy_runs
from repro.tracking.stage import Stage
from repro.tracking.store import Store

needs_mlflow = needs_extra("mlflow", "mlflow", "sqlalchemy", "alembic")
# A process of its own: the warnings of MLflow and what it loads are none of this project's.
PROGRAM = """
import sys
from repro.__main__ import main
sys.exit(main(["mlflow", *sys.argv[1:]]))
"""
READ_BACK = """
import sys
import mlflow
client = mlflow.MlflowClient(tracking_uri=sys.argv[1])
experiment = client.get_experiment_by_name("repro").experiment_id
[run] = client.search_runs([experiment], "params.basis = 't2'")
files = [file.path for file in client.list_artifacts(run.info.run_id)]
print(run.info.status, run.data.metrics, run.data.params["seeds"], files)
"""


@pytest.fixture
def runs(root: Path) -> list[str]:
    """Ids of two finished runs; a median that is no number has no place in MLflow."""

    def work(basis: str) -> Callable[[Path], dict[str, object]]:
        def make(folder: Path) -> dict[str, object]:
            (folder / "metrics.parquet").write_bytes(b"a table")
            median = {"mae_tau": 0.5, "mae_tau[0]": 0.25, "rollout_error": float("nan")}
            return {"card": {"basis": basis, "seeds": [0, 1]}, "median": median}

        return make

    made = [
        Stage("runs", basis, {"basis": basis}, {}, (), command=f"repro run basis={basis}") for basis in ("t1", "t2")
    ]
    store = Store(root)
    return [store.compute(stage, work(stage.name)).id for stage in made]


def in_process(program: str, *arguments: str, folder: Path) -> str:
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.extras
@needs_mlflow
def test_runs_arrive_once(runs: list[str], tmp_path: Path) -> None:
    uri = f"sqlite:///{tmp_path}/mlflow.db"
    assert in_process(PROGRAM, uri, "basis=t2", folder=tmp_path).startswith("1 runs copied")
    assert in_process(PROGRAM, uri, folder=tmp_path).startswith("1 runs copied")
    assert in_process(PROGRAM, uri, folder=tmp_path).startswith("0 runs copied")
    told = in_process(READ_BACK, uri, folder=tmp_path)
    assert told.split()[0] == "FINISHED"
    assert "{'mae_tau': 0.5, 'mae_tau/0': 0.25}" in told
    assert "[0, 1]" in told
    assert "metrics.parquet" in told
    assert "run.json" in told


def test_missing_extra_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mlflow", None)
    with pytest.raises(UserError, match=r"\.\[mlflow\]"):
        copy_runs([], "sqlite:///never.db")


def test_the_front_door_has_a_word_for_it(
    monkeypatch: pytest.MonkeyPatch, root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["--help"]) == 0
    assert "repro mlflow sqlite:///mlflow.db" in capsys.readouterr().out
    monkeypatch.setitem(sys.modules, "mlflow", None)
    assert cli.main(["mlflow", "sqlite:///never.db", "basis=t2"]) == 2
    told = capsys.readouterr().err
    assert "pip install -e '.[mlflow]'" in told
    assert len(told.splitlines()) == 1


def test_what_is_no_filter_is_named() -> None:
    with pytest.raises(UserError, match="t2 is no filter"):
        mlflow.main(parsed("mlflow", ["sqlite:///never.db", "t2"]))
