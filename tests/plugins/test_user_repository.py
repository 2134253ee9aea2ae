"""docs/plugins.md as written: a repository of the user with a model, an experiment, a claim, a metric, a package."""

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "plugins.md").read_text()
FILES = re.findall(r'^```\w+ title="([^"]+)"\n(.*?)^```$', PAGE, re.MULTILINE | re.DOTALL)
COMMANDS = re.findall(r"^```sh\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
NETWORK, METRIC, PAPER = (commands.splitlines() for commands in COMMANDS)


@pytest.fixture(scope="module")
def mine(tmp_path_factory):
    """The repository of the user, with all files of the page."""
    folder = tmp_path_factory.mktemp("my repository")
    for name, text in FILES:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def done(commands, mine, outputs):
    """Run commands in the user's folder; nothing of the checkout changes."""
    environment = {**os.environ, "REPRO_OUTPUTS": str(outputs), "OMP_NUM_THREADS": "1"}
    before = subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, check=True).stdout
    for command in commands:
        program = [sys.executable, "-m", "repro", *shlex.split(command)[1:]]
        ended = subprocess.run(program, cwd=mine, env=environment, capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stdout + ended.stderr
    assert subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, check=True).stdout == before
    return outputs / "report" / "smoke"


@pytest.mark.slow
def test_a_folder_of_the_user_makes_its_own_verdict(mine, tmp_path):
    report = done(NETWORK, mine, tmp_path)
    claims = pd.read_csv(report / "results" / "claims.csv").set_index("id")
    assert claims.loc["M1", "leaning"] == "supported"
    assert (report / "index.html").is_file()
    assert set(pd.read_parquet(report / "results" / "runs.parquet")["experiment"]) == {"plain"}


@pytest.mark.slow
def test_a_metric_of_the_user_is_taken_and_its_code_identified(mine, tmp_path):
    done(METRIC, mine, tmp_path)
    (run,) = (tmp_path / "runs").glob("*/run.json")
    table = pd.read_parquet(run.parent / "metrics.parquet").set_index("metric")
    assert table.loc["worst_tau", "value"] >= table.loc["mae_tau", "value"].min()
    assert "repro.evaluation.metrics.worst" in json.loads(run.read_text())["identity"]["code"]


@pytest.mark.slow
def test_another_paper_is_another_folder(mine, tmp_path):
    report = done(PAPER, mine / "another", tmp_path)
    claims = pd.read_csv(report / "results" / "claims.csv").set_index("id")
    assert list(claims.index) == ["P1"] and claims.loc["P1", "printed"] == 0.011
    assert claims.loc["P1", "ours"] == pytest.approx(0.011, rel=0.3)
    assert (report / "figures" / "errors.png").is_file()


@pytest.mark.slow
def test_an_installed_package_is_found_by_its_entry_point(mine, tmp_path):
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "install", "--no-deps"]
    subprocess.run([*pip, "--target", str(tmp_path / "site"), str(mine / "package")], check=True)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(tmp_path / "site")])}
    environment |= {"REPRO_OUTPUTS": str(tmp_path / "outputs")}
    command = ["run", "system=torque_pendulum", "basis=quadratic", "optimiser=least_squares", "scale=smoke", "seeds=1"]
    ended = subprocess.run(
        [sys.executable, "-m", "repro", *command], cwd=tmp_path, env=environment, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stdout + ended.stderr
    (table,) = (tmp_path / "outputs" / "runs").glob("*/metrics.parquet")
    found = pd.read_parquet(table).set_index(["split", "metric"])["value"]
    assert found["test", "mae_tau"] < 1e-9
