"""Every choice composes, a job's command makes the same configuration again, and a cache changes nothing."""

import json
import os
import pickle
import shlex
import shutil
import subprocess
import sys

import pytest
import yaml

from repro.config.compose import compose, plan
from repro.config.composition import _chosen, _put_together
from repro.config.overrides import EXPERIMENT, expand, experiments
from repro.config.places import ROOT, code_digest, digest
from repro.config.registry import groups, settings
from repro.errors import UserError
from repro.plugins.plugin import plugin_names
from repro.tracking.cache import Cache

# What an option needs beside it.
COMPANIONS = {
    "basis=joint": ["system=torque_pendulum"],
    "basis=rigid_body": ["system=rod"],
    "basis=spring": ["system=link"],
    "system=link": ["basis=spring"],
    "system=rod": ["basis=rigid_body"],
    "data=file": ["data.path={file}"],
    "model=blackbox": ["objective=forward"],
    "model=extended": ["system=dip"],
    "model=hamiltonian": ["objective=port"],
    "model=hinged": ["system=dip"],
    "model=sparse": ["objective=implicit", "optimiser=thresholded_least_squares"],
    "objective=implicit": ["model=sparse", "optimiser=thresholded_least_squares"],
    "objective=prediction": ["model=symoden"],
    "objective=path": ["data.labels=smoothed"],
    "objective=port": ["model=port_hamiltonian"],
    **{f"system={name}": ["model=structured"] for name in plugin_names("mechanics.systems")},
    "system=motor_pendulum": ["model=truth"],
    "optimiser=lasso": ["basis=library"],
    "optimiser=thresholded_least_squares": ["basis=library"],
    "optimiser=least_squares": ["basis=t1"],
}
OPTIONS = [f"{group}={option}" for group, options in groups().items() for option in options]


def written(path):
    """A recording of a cart that is pushed by a constant force."""
    rows = [f"{0.1 * k:.1f},{0.005 * k**2},{0.2 * k:.1f},{0.1 * k:.1f},2,1,0" for k in range(20)]
    path.write_text("\n".join(["time,x,theta,xd,thetad,force,torque", *rows]))
    return path


def assert_equal(choices):
    """Of the same keys in the same order, with equal values."""
    whole, parts = (pickle.loads(make(choices)) for make in (_chosen, _put_together))
    assert json.dumps(whole) == json.dumps(parts)


@pytest.mark.parametrize("number", range(max(map(len, groups().values()))))
def test_options_composed_apart_make_what_hydra_makes_of_them_together(number):
    """Every option of every group is in one of these jobs at least, whether its rules accept it or not."""
    assert_equal(tuple(f"{group}={options[number % len(options)]}" for group, options in groups().items()))


@pytest.mark.parametrize(
    "job",
    [
        ("model=truth", "control=dip_printed,dip", "experiment=dip_control"),  # its values lie over those of a task
        ("basis=t1", "task=random", "task.seconds=3", "experiment=sip_control"),
        ("optimiser=lasso", "experiment=sip_selection"),
        ("data=long", "experiment=ph_passivity"),
        ("scale=smoke", "data=long", "task=random", "experiment=dip_neural"),
    ],
)
def test_an_experiment_with_options_composed_apart_is_what_hydra_makes_of_it(job):
    for one in expand(job, lines=False):
        assert any(override.startswith(EXPERIMENT) for override in one)
        assert_equal(tuple(override for override in one if "." not in override))


@pytest.mark.parametrize("experiment", experiments())
def test_every_experiment_composed_from_its_file_is_what_hydra_makes_of_it(experiment):
    assert_equal((EXPERIMENT + experiment,))


def test_many_jobs_are_composed_as_each_of_them_alone():
    jobs = expand(["basis=t1,t2", "optimiser=lbfgs,levenberg_marquardt,adam", "data.samples=100,200"])
    assert [one.config for one in plan(jobs)] == [compose(job).config for job in jobs]


@pytest.mark.parametrize("option", OPTIONS)
def test_every_option_composes(option, tmp_path):
    recording = written(tmp_path / "recording.csv")
    companions = [text.replace("{file}", str(recording)) for text in COMPANIONS.get(option, [])]
    config = compose([option, *companions]).config
    assert config.members == list(range(config.scale.seeds))


@pytest.mark.parametrize("option", ["dip_best", "dip_printed"])
def test_an_option_read_without_hydra_has_the_keys_and_values_that_hydra_composes(option):
    config = compose(["system=dip", "basis=fxf", f"control={option}"]).config
    assert config.control.plain() == settings("control", option)


def test_a_base_is_no_option():
    assert not [option for options in groups().values() for option in options if option.startswith("_")]
    with pytest.raises(UserError, match="control=_mpc: allowed are dip"):
        compose(["control=_mpc"])
    with pytest.raises(UserError, match=r"control.interval: unknown key \(did you mean intervals\?\)"):
        compose(["control=sip_best", "control.interval=30"])


@pytest.mark.parametrize(
    "overrides", [["basis=t1", "seeds=[3,4]"], ["experiment=sip_energies", "sequence=joint", "scale=smoke"]]
)
def test_the_command_makes_the_same_configuration(overrides):
    made = compose(overrides)
    program, command, *again = shlex.split(made.command)
    assert (program, command) == ("repro", "run")
    (job,) = expand(again, lines=False)
    assert compose(job).config == made.config


def test_the_smallest_scale_cuts_the_seeds_of_an_experiment_and_not_those_of_a_command():
    line = ["model.factor=triangular", "seeds=100", "experiment=dip_neural"]
    assert compose([*line, "scale=smoke"]).config.members == [0, 1]
    assert compose([*line, "scale=quick"]).config.members == list(range(100))
    assert compose(["experiment=dip_neural", "scale=smoke", "seeds=3"]).config.members == [0, 1, 2]


def test_what_was_composed_is_read_from_the_cache(tmp_path):
    jobs = expand(["basis=t1,t2", "scale=quick"])
    calls = []
    first = plan(jobs, tmp_path, lambda jobs: calls.append(1))
    assert plan(jobs, tmp_path, lambda jobs: calls.append(2)) == first
    assert calls == [1]
    (file,) = tmp_path.iterdir()
    stored = Cache(file, [digest(), code_digest()])
    stored.values["basis=t1 scale=quick"] = stored.values["basis=t1 scale=quick"] | {"seeds": 7}
    stored.save()
    again = plan(jobs, tmp_path)
    assert again[0].config.members == list(range(7))
    assert again[1].config == first[1].config
    changed = Cache(file, "settings or models of yesterday")
    changed.values.update(stored.values)
    changed.save()
    assert plan(jobs, tmp_path) == first
    file.write_text("{")
    assert plan(jobs, tmp_path) == first


def test_a_job_that_reads_a_file_is_checked_each_time(tmp_path):
    recording = written(tmp_path / "recording.csv")
    jobs = expand(["data=file", f"data.path={recording}", "basis=t1"])
    plan(jobs, tmp_path / "cache")
    recording.unlink()
    with pytest.raises(UserError, match="no such file"):
        plan(jobs, tmp_path / "cache")


def test_jobs_that_share_their_choices_have_values_of_their_own():
    jobs = expand(["data.samples=1000,1001", "optimiser.epochs=7,8", "basis=t1"])
    configs = [one.config for one in plan(jobs)]
    assert [(c.data.samples, c.optimiser.epochs) for c in configs] == [(1000, 7), (1000, 8), (1001, 7), (1001, 8)]
    with pytest.raises(UserError, match=r"data\.train_fraction"):
        plan([*jobs[:-1], (*jobs[-1], "data.train_fraction=2")])


def test_the_digest_is_of_one_experiment_alone():
    assert digest("sip_basis") != digest("sip_energies")


def test_a_checkout_may_lie_in_any_folder(tmp_path):
    """Hydra reads the folder of the settings from an override, whose grammar has its own meaning for many letters."""
    checkout = tmp_path / "o'brien (1) = a, b # & {c} [d] ~ müller 漢字"
    for folder in ("src", "conf", "experiments"):
        shutil.copytree(ROOT / folder, checkout / folder, ignore=shutil.ignore_patterns("__pycache__"))
    command = [sys.executable, "-m", "repro", "run", "--cfg", "job", "experiment=sip_basis", "basis=t1"]
    environment = os.environ | {"PYTHONPATH": str(checkout / "src"), "REPRO_OUTPUTS": str(tmp_path / "outputs")}
    ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert yaml.safe_load(ended.stdout)["basis"] == {"name": "t1"}
