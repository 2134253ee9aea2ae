"""What is exported agrees with the model, in a process that cannot import this project."""

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest

import repro
from repro import __main__ as cli
from repro.config.compose import compose
from repro.errors import UserError
from repro.evaluation.predictions import predict
from repro.pipeline.finished_run import OpenedRun
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.store import Store

pytestmark = pytest.mark.usefixtures("unoptimised")

TINY = ["scale=smoke", "data.samples=300", "data.episode_steps=100", "seeds=[4,7]", "record=false"]
MODELS = {
    "t1": ["basis=t1", "optimiser=least_squares"],
    "library": ["basis=library", "optimiser=lasso"],
    "t2": ["basis=t2", "curriculum=growing_episodes", "curriculum.episodes=[50]"],
    "engineered": ["basis=engineered", "model.hidden=[6,5]", "model.activation=tanh"],
    "transform": ["basis=t2", "model.momentum_hidden=[4]", "objective.momentum_weight=1"],
    "structured": ["model=structured"],
    "friction": ["basis=t1", "optimiser=least_squares", "model.damping=full", "system.damping=[0.3,0.01]"],
    "port_hamiltonian": ["model=port_hamiltonian", "model.structure=free", "objective=port", "optimiser=lbfgs"],
    "blackbox": ["model=blackbox", "objective=forward", "model.hidden=[8]"],
}
OUTSIDE = """
import sys
sys.modules["repro"] = None
import json, os
from importlib import util
import casadi, numpy as np, torch

points = {name: values for name, values in np.load("points.npz").items()}
tensors = {name: torch.from_numpy(values) for name, values in points.items()}
for folder in sys.argv[1:]:
    spec = util.spec_from_file_location(folder, f"{folder}/model.py")
    model = util.module_from_spec(spec)
    spec.loader.exec_module(model)
    model.kinetic = lambda q, qd: model.energies(q, qd)[0]
    model.potential = lambda q, qd: model.energies(q, qd)[1]
    result = {}
    for name, needed in json.load(open(f"{folder}/about.json"))["functions"].items():
        functions = {"casadi": casadi.Function.load(f"{folder}/{name}.casadi")}
        if os.path.exists(f"{folder}/model.so"):
            functions["c"] = casadi.external(name, f"{folder}/model.so")
        for source, function in functions.items():
            values = [np.array(function(*(points[key][k] for key in needed))) for k in range(len(points["q"]))]
            result[f"{source} {name}"] = values
        function, given = getattr(model, name), [tensors[key] for key in needed]
        whole = function(*given)
        result[f"torch {name}"] = whole.numpy()
        # torch.testing would load torch.distributed, which takes a second
        same = {"rtol": 1e-9, "atol": 1e-9, "strict": True}
        close = lambda ours, other: np.testing.assert_allclose(ours.numpy(), other.numpy(), **same)
        close(torch.func.vmap(function)(*given), whole)
        if folder in (sys.argv[1], sys.argv[-1]):  # the same lines in every file
            close(function(given[0].tolist(), *(each.numpy() for each in given[1:])), whole)
            close(function(*(each[:1].expand(5, 2) for each in given))[4], whole[0])
            close(function(given[0][0], *given[1:])[0], whole[0])
        for wrong in ([each[:, :1] for each in given], [given[0][:2], *given[1:]]):
            try:
                function(*wrong)
            except ValueError as error:
                assert "\\n" not in str(error)
            else:
                raise AssertionError(f"{name} takes {wrong}")
    np.savez(f"{folder}.npz", **result)
"""


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    return tmp_path_factory.mktemp("outputs")


@pytest.fixture(scope="module")
def exported(outputs, tmp_path_factory, unoptimised):
    """Every model exported through the command and evaluated at five points by a process of its own."""
    place = tmp_path_factory.mktemp("exported")
    rng = np.random.default_rng(0)
    np.savez(place / "points.npz", **{key: rng.uniform(-2, 2, (5, 2)) for key in ("q", "qd", "qdd", "tau")})
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("REPRO_OUTPUTS", str(outputs))
        for name in MODELS:
            assert cli.main(["export", made(outputs, name).id, str(place / name), "--member", "7"]) == 0
    if shutil.which("cc"):
        compile_command = ["cc", "-O1", "-shared", "-fPIC", "model.c", "-o", "model.so", "-lm"]
        subprocess.run(compile_command, cwd=place / "t2", check=True)
    subprocess.run([sys.executable, "-c", OUTSIDE, *MODELS], cwd=place, check=True)
    return place


def made(outputs, name):
    composed = compose([*TINY, *MODELS[name]])
    return execute(Pipeline.of(composed.config, composed.command), Store(outputs))


@pytest.mark.parametrize("name", MODELS)
def test_exported_functions_agree_with_the_model(name, outputs, exported):
    with np.load(exported / f"{name}.npz") as stored:
        result = dict(stored)
    with np.load(exported / "points.npz") as stored:
        arrays = [stored[key][None] for key in ("q", "qd", "qdd", "tau")]
    opened = repro.load_run(made(outputs, name).id, root=outputs)
    said = predict(opened.model, opened.parameters[1:], *arrays)
    expected = {"forward": said.acceleration}
    if opened.model.energetic:
        expected |= {"kinetic": said.kinetic, "potential": said.potential, "lagrangian": said.lagrangian}
        expected |= {"momentum": said.momentum, "mass_matrix": said.mass, "inverse": said.tau}
        expected |= {"hamiltonian": said.hamiltonian(arrays[1])}
    assert {key.partition(" ")[2] for key in result} == set(expected)
    for key, values in result.items():
        wanted = expected[key.partition(" ")[2]][0]
        scale = max(1.0, np.abs(wanted).max())
        np.testing.assert_allclose(values.reshape(wanted.shape), wanted, rtol=0, atol=1e-9 * scale, err_msg=key)


def test_what_cannot_be_exported_is_said(outputs, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(outputs))
    run = made(outputs, "t1")
    fit = run.identity.upstream["fit"]
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("")
    for arguments, said in (
        ([run.id, str(tmp_path / "full")], "exists and is not empty"),
        ([run.id, str(tmp_path / "new"), "--member", "5"], "--member 5: " + run.id + " has the seeds 4, 7"),
        ([fit, str(tmp_path / "new")], "is no run but one of fits"),
        (["nothing", str(tmp_path / "new")], "no stage nothing under"),
    ):
        assert cli.main(["export", *arguments]) == 2
        told = capsys.readouterr().err
        assert said in told
        assert len(told.splitlines()) == 1
    assert not (tmp_path / "new").exists()
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["thesis.tex"]


def test_a_run_opens_to_its_model_data_and_tables(outputs):
    record = made(outputs, "t2")
    run = repro.load_run(record.id[-10:], root=outputs)
    assert isinstance(run, OpenedRun)
    assert run.seeds == [4, 7]
    assert run.data.q.shape == (2, 300, 2)
    assert run.parameters.shape == (2, run.model.n_parameters)
    assert run.settings.basis == "t2"
    metrics = run.table("metrics")
    test = run.data.test
    error = predict(run.model, run.parameters, test.q, test.qd, test.qdd, test.tau).tau - test.tau
    stored = metrics[(metrics["split"] == "test") & (metrics["metric"] == "mae_tau")].set_index("member")["value"]
    np.testing.assert_allclose(stored.loc[[4, 7]], np.abs(error).mean((1, 2)), rtol=1e-12)

    table = repro.load_runs(root=outputs, metric="mae_tau", split="test", basis="t2", momentum_weight=0.0)
    assert set(table["member"]) == {4, 7}
    about = json.loads(json.dumps(run.card))
    assert about["model"] == "lagrangian"


def test_weights_of_older_code_are_refused(outputs, monkeypatch):
    record = made(outputs, "t1")
    monkeypatch.setattr("repro.pipeline.finished_run.load_parameters", lambda folder: np.zeros((2, 9)))
    with pytest.raises(UserError, match="has 9 weights per seed, its model now takes 4"):
        _ = repro.load_run(record.id, root=outputs).parameters
