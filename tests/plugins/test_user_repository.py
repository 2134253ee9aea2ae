"""docs/plugins.md as written: a repository of the user with a model, an experiment and a claim."""

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
COMMANDS = re.findall(r"^```sh\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)[0].splitlines()


@pytest.mark.slow
def test_a_folder_of_the_user_makes_its_own_verdict(tmp_path):
    mine, outputs = tmp_path / "my repository", tmp_path / "outputs"
    for name, text in FILES:
        (mine / name).parent.mkdir(parents=True, exist_ok=True)
        (mine / name).write_text(text)
    environment = {**os.environ, "REPRO_OUTPUTS": str(outputs), "OMP_NUM_THREADS": "1"}
    before = subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, check=True).stdout
    for command in COMMANDS:
        program = [sys.executable, "-m", "repro.cli", *shlex.split(command)[1:]]
        done = subprocess.run(program, cwd=mine, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    report = outputs / "report" / "smoke"
    claims = pd.read_csv(report / "results" / "claims.csv").set_index("id")
    assert claims.loc["M1", "leaning"] == "supported"
    assert (report / "index.html").is_file()
    assert set(pd.read_parquet(report / "results" / "runs.parquet")["experiment"]) == {"plain"}
    assert subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, check=True).stdout == before
