"""Sweeps as a user runs them: what fails, is stopped, shared or finished already."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from repro import __main__ as cli
from repro.config.overrides import expand

SMALL = ["scale=smoke", "data.samples=200", "data.episode_steps=100", "record=false"]
QUICK = ["basis=t1", "optimiser=least_squares", *SMALL]


@pytest.fixture
def outputs(tmp_path, monkeypatch):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    return tmp_path / "outputs"


def command(*arguments):
    return [sys.executable, "-m", "repro", *arguments]


def repro(*arguments):
    return subprocess.run(command(*arguments), capture_output=True, text=True, check=False)


def stamps(outputs, kind="*"):
    return {path: path.stat().st_mtime_ns for path in outputs.glob(f"{kind}/*/run.json")}


def test_a_sweep_runs_once_and_a_failing_job_costs_itself_alone(outputs, tmp_path, capsys):
    good, broken = tmp_path / "good.csv", tmp_path / "broken.csv"
    rows = ["time,x,theta,xd,thetad,force,torque"]
    rows += [f"{0.04 * k},{k % 7},{np.sin(k)},{np.cos(k)},{k % 5},{k % 3},0" for k in range(100)]
    good.write_text("\n".join(rows))
    broken.write_text("\n".join(rows).replace(",1,", ",1e200,"))  # its squares overflow
    file = ["data=file", "data.checks=warn"]
    sweep = ["run", "-m", "basis=t1", "optimiser=least_squares", *file, f"data.path={good},{broken}", "seeds=1"]

    assert cli.main(sweep) == 1
    said = capsys.readouterr()
    assert "1 of 2 jobs failed" in said.out
    assert "infs" in said.out
    assert f"repeat: repro run basis=t1 optimiser=least_squares {' '.join(file)} data.path={broken}" in said.out
    assert "Traceback" not in said.out + said.err
    made = stamps(outputs, "runs")
    assert len(made) == 1

    assert cli.main([*sweep, "--failed", "--dry-run"]) == 0
    assert "1 job, 1 to run" in capsys.readouterr().out

    broken.write_text("\n".join(rows).replace("0.0,0,", "0.0,1,", 1))
    assert cli.main(sweep) == 0
    assert made.items() < stamps(outputs, "runs").items()


def test_a_finished_sweep_runs_nothing(outputs, capsys):
    assert cli.main(["run", *QUICK]) == 0
    before = stamps(outputs)
    assert len(before) == 3
    assert cli.main(["run", "-m", *QUICK]) == 0
    assert cli.main(["run", "-m", "--dry-run", *QUICK]) == 0
    assert "1 job, 0 to run" in capsys.readouterr().out
    assert stamps(outputs) == before


def test_an_experiment_is_listed_and_status_knows_it(outputs, capsys):
    job = expand(["experiment=sip_selection", "optimiser=lasso", "data.tau_noise=0.1", *SMALL], lines=False)[0]
    listed = ["experiment=sip_selection", "optimiser=lasso", "data.tau_noise=0.1", "scale=smoke", "record=false"]
    assert "data.samples=200" in job
    assert cli.main(["run", *listed]) == 0
    file = outputs / "experiments" / "smoke" / "sip_selection.json"
    content = json.loads(file.read_bytes())
    (entry,) = content["jobs"]
    assert entry["command"].startswith("repro run experiment=sip_selection optimiser=lasso")
    capsys.readouterr()

    assert cli.main(["status", "--json"]) == 0
    states = {item["id"]: item["state"] for item in json.loads(capsys.readouterr().out)}
    assert states[entry["run"]] == "done"
    assert set(states.values()) == {"done"}

    assert cli.main(["run", *listed, "seeds=3"]) == 0
    assert len(json.loads(file.read_bytes())["jobs"]) == 2
    assert cli.main(["run", *listed[:3], "model=trivial", *SMALL]) == 0
    assert len(json.loads(file.read_bytes())["jobs"]) == 2, "a setting that the experiment does not ask for"


def test_two_at_once_share_the_work(outputs):
    arguments = ["run", "-m", *QUICK, "seeds=1,2,3"]
    both = [subprocess.Popen(command(*arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE) for _ in range(2)]
    told = [process.communicate() for process in both]
    assert [process.returncode for process in both] == [0, 0], told
    assert len(stamps(outputs, "runs")) == 3
    assert not list(outputs.glob("*/.failed/*"))


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "file" / "outputs"))
    assert cli.main(["run", *QUICK]) == 2
    assert f"{tmp_path / 'file'} is a file, not a folder" in capsys.readouterr().err


@pytest.fixture
def mounted(tmp_path):
    """A small file system of its own."""
    folder = tmp_path / "mounted"
    folder.mkdir()
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", folder], capture_output=True, check=False)
    if made.returncode:
        pytest.skip("mounting needs more rights than these tests have")
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def test_a_full_disk_is_said_and_loses_nothing(mounted, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(mounted / "outputs"))
    assert cli.main(["run", *QUICK]) == 0
    before = stamps(mounted / "outputs")
    filler = mounted / "filler"
    with filler.open("wb") as file:
        while shutil.disk_usage(mounted).free:
            try:
                file.write(b"0" * 4096)
                file.flush()
            except OSError:
                break
    capsys.readouterr()
    assert cli.main(["run", *QUICK, "seeds=5"]) == 2
    said = capsys.readouterr().err
    assert "the disk is full; free some space" in said
    assert len(said.splitlines()) == 1
    assert stamps(mounted / "outputs") == before
    filler.unlink()
    assert cli.main(["run", *QUICK, "seeds=5"]) == 0


def test_a_read_only_folder_is_said_and_finished_runs_are_still_found(mounted, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(mounted / "outputs"))
    assert cli.main(["run", *QUICK]) == 0
    subprocess.run(["mount", "-o", "remount,ro", mounted], check=True)
    capsys.readouterr()
    assert cli.main(["run", *QUICK]) == 0
    assert "mae_tau" in capsys.readouterr().out
    assert cli.main(["run", *QUICK, "seeds=5"]) == 2
    said = capsys.readouterr().err
    assert "the file system is read-only" in said
    assert len(said.splitlines()) == 1


@pytest.mark.slow
def test_ctrl_c_in_a_training_resumes_to_the_same_bits(tmp_path, monkeypatch):
    training = ["run", "basis=t2", "scale=quick", "optimiser.epochs=20000", "seeds=2", "record=false"]
    weights = {}
    for name in ("stopped", "whole"):
        monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / name))
        if name == "stopped":
            process = subprocess.Popen(command(*training), stderr=subprocess.PIPE, text=True)
            deadline = time.monotonic() + 120
            while not list((tmp_path / name).glob("fits/.work/*/checkpoint.pt")):
                assert process.poll() is None, "it ended before its first checkpoint"
                assert time.monotonic() < deadline
                time.sleep(0.2)
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=60)[1]
            assert process.returncode == 130
            assert re.search(r"to go on: (python -m )?repro run basis=t2", said)
            assert "Traceback" not in said
            assert not stamps(tmp_path / name, "fits")
        done = repro(*training)
        assert done.returncode == 0, done.stderr
        (file,) = (tmp_path / name).glob("fits/*/parameters.npz")
        with np.load(file) as stored:
            weights[name] = stored["parameters"]
    np.testing.assert_array_equal(weights["stopped"], weights["whole"])


@pytest.mark.slow
def test_two_reproductions_at_once(outputs):
    arguments = ["reproduce", "scale=smoke", "experiment=sip_selection"]
    both = [subprocess.Popen(command(*arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE) for _ in range(2)]
    told = [process.communicate() for process in both]
    assert [process.returncode for process in both] == [0, 0], told
    assert not list(outputs.glob("*/.failed/*"))
    before = stamps(outputs)
    started = time.monotonic()
    assert repro(*arguments).returncode == 0
    assert time.monotonic() - started < 15
    assert stamps(outputs) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("launcher", "plugin"),
    [("submitit_local", "hydra_plugins.hydra_submitit_launcher"), ("ray", "hydra_plugins.hydra_ray_launcher")],
)
def test_hydras_launchers_make_the_same_runs(outputs, launcher, plugin):
    pytest.importorskip(plugin, reason=f"hydra/launcher={launcher} is an extra that is not installed")
    done = repro("run", "-m", *QUICK, "seeds=1,2", f"hydra/launcher={launcher}")
    assert done.returncode == 0, done.stderr
    before = stamps(outputs)
    assert len([path for path in before if "runs" in path.parts]) == 2
    assert cli.main(["run", "-m", *QUICK, "seeds=1,2"]) == 0
    assert stamps(outputs) == before
    assert os.environ["REPRO_OUTPUTS"] == str(outputs)
