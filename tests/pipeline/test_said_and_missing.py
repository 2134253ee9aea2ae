"""What a run says to its user, once and in its record, and what it never invents."""

import json
import os
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from repro import __main__ as cli
from repro.config.compose import compose
from repro.config.schema import scaled
from repro.library.signals import learned_energies
from repro.mechanics.derive import energies_along
from repro.mechanics.system import load
from repro.models.kinds.truth import Truth


@pytest.fixture
def outputs(tmp_path, monkeypatch):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    return tmp_path / "outputs"


def test_a_motion_that_diverges_has_no_energies_from_there_on():
    system = load("sip")
    model = Truth(system)
    weights = model.initial([np.random.default_rng(0)])
    states = np.random.default_rng(1).normal(size=(1, 6, 4))
    states[0, 4:] = np.nan, np.inf, 0.0, 0.0
    learned = learned_energies(model, weights, system, states)
    for energy in learned.values():
        assert np.isnan(energy[0, 4:]).all() and np.isfinite(energy[0, :4]).all()
    expected = energies_along(system, states[:, :4])
    assert learned["H"][0, :4] == pytest.approx(expected["H"][0], abs=1e-9)


def recording(folder):
    time = 0.04 * np.arange(100)
    columns = {"x": np.sin(time), "theta": np.cos(2 * time), "xd": np.cos(time), "thetad": -2 * np.sin(2 * time)}
    forces = {"force": np.sin(3 * time), "torque": np.zeros(100), "time": time}
    pd.DataFrame({**columns, **forces}).to_csv(folder / "own.csv", index=False)
    return folder / "own.csv"


def of_file(file, *more):
    roles = {"q": "x,theta", "qd": "xd,thetad", "tau": "force,torque", "time": "time"}
    columns = [f"data.columns.{role}=[{names}]" for role, names in roles.items()]
    return ["run", "data=file", f"data.path={file}", *columns, "scale=smoke", "seeds=1", "basis=t1", *more]


@pytest.mark.slow
def test_a_notice_of_the_data_is_shown_once_and_by_show(outputs, tmp_path, capfd):
    said = "qdd is not recorded"
    file = recording(tmp_path)
    assert cli.main(of_file(file, "-m", "optimiser=least_squares,lbfgs")) == 0
    assert capfd.readouterr().err.count(said) == 1
    assert cli.main(of_file(file, "optimiser=levenberg_marquardt")) == 0  # its data are there already
    assert capfd.readouterr().err.count(said) == 1
    for run in (outputs / "runs").glob("[!.]*/run.json"):
        assert cli.main(["show", run.parent.name]) == 0
        shown = capfd.readouterr().out
        assert "\nnotices\n" in shown and f"own.csv: {said}" in shown


@pytest.mark.slow
def test_without_a_compiler_one_notice_says_so(outputs, tmp_path):
    environment = {**os.environ, "PATH": "/nonexistent", "XDG_CACHE_HOME": str(tmp_path / "cache"), "CC": ""}
    overrides = ["basis=t2", "optimiser.epochs=2", "data.samples=100,110", "scale=smoke", "seeds=1", "record=false"]
    command = [sys.executable, "-m", "repro", "run", "-m", *overrides]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stderr.count("no C compiler") == 1
    (run, *_) = (outputs / "runs").glob("*/run.json")
    assert "no C compiler" in str(json.loads(run.read_text())["summary"]["notices"])


@pytest.mark.parametrize(
    ("given", "read", "value"),
    [
        ("data.samples=50000", lambda config: config.data.samples, 50_000),
        ("optimiser.epochs=300", lambda config: config.optimiser.epochs, 300),
        ("optimiser=lbfgs optimiser.iterations=90", lambda config: config.optimiser.iterations, 90),
        ("sequence=joint sequence.initial_angles=40", lambda config: config.sequence.initial_angles, 40),
        ("sequence=pretrain sequence.pretraining_epochs=70", lambda config: config.sequence.pretraining_epochs, 70),
        ("curriculum=growing_episodes curriculum.samples=900", lambda config: config.curriculum.samples, 900),
        ("energies.horizons=[7.0]", lambda config: list(config.energies.horizons), [7.0]),
        ("control=sip task.seconds=9", lambda config: config.task.seconds, 9),
        ("control=sip task=random task.initial_states=9", lambda config: config.loops, 9),
        ("system=link basis=spring data.reset=random chain=[300]", lambda config: list(config.chain), [300]),
    ],
)
def test_an_explicit_value_wins_over_the_scale(given, read, value):
    words = given.split()
    assert read(scaled(compose(["scale=smoke", *words]).config)) == value
    assert read(scaled(compose(["scale=smoke", *words[:-1]]).config)) != value


def test_what_an_experiment_says_is_cut_by_its_scale_and_what_is_given_beside_it_is_not():
    line = ["data.samples=3000", "experiment=sip_basis", "basis=t1", "scale=smoke"]
    assert scaled(compose(line).config).data.samples == 400
    assert scaled(compose([*line[1:], "data.samples=3000"]).config).data.samples == 3000
