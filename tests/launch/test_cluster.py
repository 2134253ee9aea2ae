"""Sweeps on Hydra's launchers: one failing job costs itself alone, nothing is made twice, settings arrive.

The launchers are extras, and SLURM needs a cluster (one node will do); where one is not there its tests are skipped.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from repro.commands import run
from repro.commands.arguments import parsed
from repro.config.overrides import expand
from repro.errors import UserError
from repro.launch import cluster
from repro.launch.jobs import Job
from repro.sweep.missing import RUN_JOB
from repro.sweep.planned_job import plan_jobs
from repro.tracking.paths import Paths
from repro.tracking.store import Store

SMOKE = ("scale=smoke", "basis=t1", "optimiser=adam")
CLOSED_FORM = ("scale=smoke", "basis=t1", "optimiser=least_squares", "data=file", "data.checks=warn")


@pytest.fixture
def outputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    root = tmp_path / "out puts"  # a space, as on many a shared disk
    monkeypatch.setenv("REPRO_OUTPUTS", str(root))
    return root


@pytest.fixture
def recordings(tmp_path: Path) -> tuple[Path, Path]:
    """A recording, and one whose squares overflow, so that the closed form fails where it runs."""
    time_s = np.arange(200) * 0.04
    motion = {"x": np.sin(time_s), "theta": np.cos(time_s), "xd": np.cos(time_s), "thetad": -np.sin(time_s)}
    table = pd.DataFrame({"time": time_s, **motion, "force": np.cos(3 * time_s), "torque": 0.0})
    good, bad = tmp_path / "good.csv", tmp_path / "bad.csv"
    table.to_csv(good, index=False)
    table.assign(xd=1e200 * table["xd"]).to_csv(bad, index=False)
    return good, bad


def job(outputs: Path, *overrides: str) -> dict[str, Any]:
    """One job, as a sweep hands them to a launcher."""
    [one] = plan_jobs(expand(overrides), Paths(outputs))
    resolved = one.composed.config.model_dump()
    arguments = {"resolved": resolved, "outputs": str(outputs), "command": one.composed.command}
    return {"name": one.label, "target": RUN_JOB, "arguments": arguments, "command": one.composed.command}


def run_here(outputs: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Run a job as a launcher does on its machine, and read how it ended."""
    folder = outputs / "logs"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "jobs.json").write_text(json.dumps([job]))
    cluster._run_one(SimpleNamespace(folder=str(folder), job=0))
    return dict(json.loads((folder / "0" / "ended.json").read_text()))


def test_unknown_places_are_named() -> None:
    with pytest.raises(UserError, match="allowed are submitit_slurm, submitit_local, ray"):
        cluster.split(["hydra/launcher=joblib"])
    with pytest.raises(UserError, match=f"go with hydra/launcher={re.escape('|'.join(cluster.EXTRAS))}"):
        run.main(parsed("run", ["-m", "basis=t1,t2", "hydra.launcher.timeout_min=3"]))


def test_missing_extra_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(cluster.EXTRAS, "ray", ("ray", "hydra_plugins.not_installed"))
    with pytest.raises(UserError, match=re.escape("pip install -e '.[ray]'")):
        cluster.split(["hydra/launcher=ray"])


@pytest.mark.parametrize(
    ("launcher", "flag", "message"),
    [
        (
            "submitit_slurm",
            "--workers=4",
            "--workers is for jobs on this machine, not for hydra/launcher=submitit_slurm",
        ),
        ("submitit_slurm", "--timeout=60", "set hydra.launcher.timeout_min=N instead"),
        ("submitit_local", "--timeout=60", "set hydra.launcher.timeout_min=N instead"),
        ("submitit_local", "--workers=4", "this launcher has no such setting"),
        ("ray", "--workers=4", "set +hydra.launcher.ray.init.num_cpus=N instead"),
    ],
)
def test_flags_for_one_machine_are_refused_on_a_launcher(
    monkeypatch: pytest.MonkeyPatch, outputs: Path, launcher: str, flag: str, message: str
) -> None:
    monkeypatch.setitem(cluster.EXTRAS, launcher, ("slurm", "hydra"))
    with pytest.raises(UserError, match=re.escape(message)) as error:
        run.main(parsed("run", ["-m", "basis=t1,t2", f"hydra/launcher={launcher}", flag]))
    assert len(str(error.value).splitlines()) == 1
    assert not outputs.exists()


def test_settings_of_the_launcher_make_no_jobs() -> None:
    assert cluster.split(["basis=t1,t2"]) == (["basis=t1,t2"], [])


def test_a_failing_job_ends_its_launcher_s_process_well(outputs: Path, recordings: tuple[Path, Path]) -> None:
    ended = run_here(outputs, job(outputs, *CLOSED_FORM, f"data.path={recordings[1]}"))
    assert ended["outcome"] == "failed"
    assert "infs" in ended["error"]


def test_a_killed_job_ends_its_launcher_s_process_well(outputs: Path) -> None:
    killer = threading.Thread(target=kill_maker_of_a_fit, args=(outputs,))
    killer.start()
    ended = run_here(outputs, job(outputs, *SMOKE, "optimiser.epochs=10000000000"))
    killer.join()
    assert ended["outcome"] == "killed"
    assert "SIGKILL" in ended["error"]


def kill_maker_of_a_fit(outputs: Path) -> None:
    end = time.monotonic() + 60
    while time.monotonic() < end:
        for holder in (outputs / "fits" / ".work").glob("*/holder.json"):
            os.kill(json.loads(holder.read_text())["pid"], signal.SIGKILL)
            return
        time.sleep(0.1)


def test_a_job_without_an_ending_was_killed(outputs: Path) -> None:
    result = cluster._ending(outputs, 0, Job("job 0", "module:function", {}, "repro run"))
    assert result.outcome == "killed"
    assert result.log == str(outputs)


def slurm_is_there() -> bool:
    if shutil.which("sinfo") is None:
        return False
    return "idle" in subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True, check=False).stdout


@pytest.fixture
def launcher() -> Callable[[str], list[str]]:
    """The overrides of a launcher, small enough for any machine; skips where it is not there."""
    settings = {
        "submitit_local": ["hydra.launcher.timeout_min=5"],
        "submitit_slurm": ["hydra.launcher.timeout_min=5", "hydra.launcher.cpus_per_task=1", "hydra.launcher.mem_gb=1"],
        "ray": ["+hydra.launcher.ray.init.num_cpus=2", "+hydra.launcher.ray.remote.num_cpus=1"],
    }

    def overrides(name: str) -> list[str]:
        extra, plugin = cluster.EXTRAS[name]
        if not cluster._is_installed(plugin):
            pytest.skip(f"the extra {extra} is not installed: pip install -e '.[{extra}]'")
        if name == "submitit_slurm" and not slurm_is_there():
            pytest.skip("no idle SLURM node answers to sinfo")
        return [f"hydra/launcher={name}", *settings[name]]

    return overrides


@pytest.mark.extras
@pytest.mark.parametrize("name", list(cluster.EXTRAS))
def test_a_sweep_on_a_launcher(
    name: str,
    launcher: Callable[[str], list[str]],
    outputs: Path,
    recordings: tuple[Path, Path],
    capsys: pytest.CaptureFixture[str],
) -> None:
    good, bad = recordings
    where = launcher(name)
    assert run.main(parsed("run", ["-m", *CLOSED_FORM, f"data.path={bad},{good}", *where])) == 1
    message = capsys.readouterr().out
    assert "1 of 2 jobs failed" in message
    assert "infs" in message
    assert len(Store(outputs).records("runs")) == 1
    logs = set((outputs / "logs").iterdir())
    assert run.main(parsed("run", ["-m", *CLOSED_FORM, f"data.path={good}", *where])) == 0
    assert set((outputs / "logs").iterdir()) == logs, "a finished run was handed to the launcher again"


@pytest.mark.extras
def test_settings_reach_slurm(launcher: Callable[[str], list[str]], outputs: Path) -> None:
    where = [*launcher("submitit_slurm"), "hydra.launcher.timeout_min=7", "hydra.launcher.cpus_per_task=2"]
    assert run.main(parsed("run", [*SMOKE, *where])) == 0
    [submitted] = (outputs / "logs").glob("*/.submitit/*/*_submitted.pkl")
    number = submitted.name.partition("_")[0]
    shown = subprocess.run(["scontrol", "show", "job", number], capture_output=True, text=True, check=True).stdout
    assert "TimeLimit=00:07:00" in shown
    assert "CPUs/Task=2" in shown
    assert re.search(r"TRES=\S*mem=1G", shown)


@pytest.mark.extras
def test_a_launcher_s_process_that_is_killed_costs_its_job_alone(
    launcher: Callable[[str], list[str]], outputs: Path
) -> None:
    """The scheduler's hardest end leaves no word; the sweep still waits for the other job."""
    where = launcher("submitit_local")
    killer = threading.Thread(target=kill_launcher_of_a_fit, args=(outputs,))
    killer.start()
    assert run.main(parsed("run", ["-m", *SMOKE, "optimiser.epochs=10000000000,20000000", *where])) == 1
    killer.join()
    [made] = Store(outputs).records("runs")
    assert "20000000" in made.provenance.command


def kill_launcher_of_a_fit(outputs: Path) -> None:
    end = time.monotonic() + 60
    while time.monotonic() < end:
        for holder in (outputs / "fits" / ".work").glob("*/holder.json"):
            content = json.loads(holder.read_text())
            if "10000000000" in content["command"]:
                os.kill(ancestor(content["pid"], "submitit.core._submit"), signal.SIGKILL)
                return
        time.sleep(0.1)


def ancestor(pid: int, word: str) -> int:
    """The nearest process above `pid` whose command line has a word."""
    while word not in Path(f"/proc/{pid}/cmdline").read_text():
        pid = int(re.search(r"PPid:\s+(\d+)", Path(f"/proc/{pid}/status").read_text())[1])
    return pid
