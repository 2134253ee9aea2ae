"""The numbers that docs/real-data.md prints for published recordings come out of its commands again."""

import re
import shlex
from pathlib import Path

import pandas as pd
import pytest

from repro.config.compose import compose
from repro.config.overrides import expand
from repro.config.places import ROOT
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.store import Store

RECORDINGS = ROOT.parent / "shared" / "data"
PAGE = (ROOT / "docs" / "real-data.md").read_text()
CELLS = {"MAE τ": "mae_tau", "MAE q̈": "mae_qdd"}
CART = {"x": "s", "theta": "phi1", "xd": "Ds", "thetad": "Dphi", "force": "u", "xdd": "DDs", "thetadd": "DDphi"}
MOTOR = {"t": "time", "theta": "position", "thetad": "velocity", "tau": "torque"}
# file of the command, collected recording, its columns as published, job of the command's list, row of the page, and
# the relative tolerance: a network's minimum depends on the order of sums, an error near rounding on the machine
ROWS = [
    ("characters.csv", "delan_characters", {}, "model=structured", "| `structured` | 2.0e-5", 0.5),
    ("single_free.csv", "multiarm_single_free", {}, "basis=joint", "| `basis=joint` | 0.126", 0.02),
    ("single_free.csv", "multiarm_single_free", {}, "model=structured", "| `structured` | 0.129", 0.05),
    ("singlePend.csv", "bystricky_cartpole", CART, "model=structured", "| `structured` | 2.4e-6", 0.5),
    ("data_measured.csv", "dfki_pendulum_ddp", MOTOR, "data.labels=recorded", "| `ddp` | recorded |", 0.02),
    (
        "data_measured.csv",
        "dfki_pendulum_energy",
        MOTOR,
        "data.labels=recorded",
        "| `energy_shaping` | recorded |",
        0.02,
    ),
]


@pytest.mark.slow
@pytest.mark.skipif(not RECORDINGS.is_dir(), reason="the published recordings are not beside the checkout")
@pytest.mark.parametrize(("file", "recording", "published", "choice", "row", "tolerance"), ROWS)
def test_a_row_of_the_page_comes_out_of_its_command(
    file: str,
    recording: str,
    published: dict[str, str],
    choice: str,
    row: str,
    tolerance: float,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pd.read_csv(RECORDINGS / f"{recording}.csv.gz").rename(columns=published).to_csv(tmp_path / file, index=False)
    monkeypatch.chdir(tmp_path)
    (job,) = [job for job in _jobs() if f"data.path={file}" in job and choice in job and "objective=balance" not in job]
    composed = compose([*job, "record=false"])
    run = execute(Pipeline.of(composed.config, composed.command), Store(tmp_path / "outputs"))
    printed = _printed(row)
    assert printed
    assert {name: run.summary["median"][name] for name in printed} == pytest.approx(printed, rel=tolerance)


def _jobs() -> list[list[str]]:
    """Every job of every command of the page."""
    commands = re.findall(r"^\.venv/bin/repro run (.+?)$", PAGE, re.MULTILINE)
    return [job for command in commands for job in expand([word for word in shlex.split(command) if word != "-m"])]


def _printed(row: str) -> dict[str, float]:
    """The metrics in the row that begins like this; the cell after an error is that of the mean."""
    lines = PAGE.splitlines()
    (at,) = [i for i, line in enumerate(lines) if line.startswith(row)]
    top = max(i for i in range(at) if lines[i].startswith("|---")) - 1
    names, cells = ([cell.strip() for cell in line.strip("|").split("|")] for line in (lines[top], lines[at]))
    found = {}
    for k, name in enumerate(names):
        if name in CELLS:
            found[CELLS[name]], found[f"mean_{CELLS[name]}"] = float(cells[k]), float(cells[k + 1])
    return found
