"""What needs no networks loads no torch, which takes longer to load than such a run to compute."""

import json
import os
import subprocess
import sys

import pytest

from repro.sweep.missing import preload
from repro.sweep.planned_job import plan_jobs
from repro.tracking.paths import Paths

PROGRAM = """
import json, sys
from pathlib import Path
from repro import __main__ as cli
from repro.config.compose import compose
from repro.pipeline.run import run_job
outputs = sys.argv[1]
for line in json.loads(sys.argv[2]):
    composed = compose((*line, "data.samples=100", "seeds=1"))
    run_job(composed.config.model_dump(mode="json"), outputs, composed.command)
assert cli.main(["identify", "basis=t1", "data.samples=100"]) == 0
print(sorted({"torch", "jax", "sympy", "sklearn", "matplotlib"} & set(sys.modules)))
"""
CLOSED_FORM = ("basis=t1", "optimiser=least_squares")


def test_closed_forms_anchors_and_identify_load_no_torch(tmp_path):
    lines = json.dumps([CLOSED_FORM, ("model=trivial",), ("model=degenerate", "record=false")])
    output = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(tmp_path), lines],
        capture_output=True, text=True, check=True, env={**os.environ, "REPRO_OUTPUTS": str(tmp_path)},
    ).stdout  # fmt: skip
    assert output.splitlines()[-1] == "[]"


PLANNED = """
import json, sys
from pathlib import Path
from repro.sweep.planned_job import plan_jobs
from repro.tracking.paths import Paths
jobs = plan_jobs([tuple(job) for job in json.loads(sys.argv[2])], Paths(Path(sys.argv[1])))
assert all(job.expected_seconds > 0 for job in jobs)
print("torch" in sys.modules)
"""


def test_networks_are_planned_without_it(tmp_path):
    jobs = [
        ("model=structured",),
        ("model=symoden", "objective=prediction"),
        ("model=blackbox", "objective=forward"),
        ("model=hamiltonian", "objective=port"),
    ]
    command = [sys.executable, "-c", PLANNED, str(tmp_path), json.dumps(jobs)]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "False\n"


@pytest.mark.parametrize(
    "job", [CLOSED_FORM, ("model=trivial",), ("model=truth", "optimiser=thresholded_least_squares")]
)
def test_the_server_of_their_jobs_loads_none(job):
    assert "torch" not in preload([job])


@pytest.mark.parametrize("jobs", [[()], [("basis=t1",)], [CLOSED_FORM, ("model=structured",)], [("optimiser=adam",)]])
def test_the_server_of_jobs_that_may_train_networks_loads_it(jobs):
    assert "torch" in preload(jobs)


def test_on_a_terminal_a_word_comes_before_settings_are_composed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    heard = []
    for _ in range(2):  # what is composed already needs none
        plan_jobs([CLOSED_FORM], Paths(tmp_path), lambda jobs: heard.append((jobs, capsys.readouterr().err)))
    assert heard == [([CLOSED_FORM], "composing 1 new job\n")]
