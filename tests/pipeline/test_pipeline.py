"""One run: what its stages depend on, that it resumes where it was stopped, and that damage is mended."""

import json

import numpy as np
import pytest

from repro.config.compose import compose
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute, run_job
from repro.pipeline.stages import fit
from repro.tracking import progress
from repro.tracking.store import Store

TINY = ["scale=smoke", "data.samples=200", "data.episode_steps=100", "seeds=2", "record=false"]


def tiny(*overrides):
    given = {override.partition("=")[0] for override in overrides}
    return [*(text for text in TINY if text.partition("=")[0] not in given), *overrides]


def pipeline(*overrides):
    composed = compose(tiny(*overrides))
    return Pipeline.of(composed.config, composed.command)


def ids(*overrides):
    made = pipeline(*overrides)
    return {"data": made.data_stages["data"].id, "fit": made.fit_stage.id, "run": made.run_stage.id}


def weights(record):
    fit = record.folder.parents[1] / "fits" / record.identity.upstream["fit"]
    with np.load(fit / "parameters.npz") as stored:
        return stored["parameters"]


@pytest.mark.parametrize(
    ("change", "changed"),
    [
        ("data.force_limit=4", {"data", "fit", "run"}),
        ("seeds=3", {"data", "fit", "run"}),
        ("reading=printed", {"data", "fit", "run"}),
        ("optimiser.learning_rate=0.02", {"fit", "run"}),
        ("model.hidden=[11]", {"fit", "run"}),
        ("energies=canonical", {"run"}),
        ("device=cuda", {"fit", "run"}),
        ("device=cpu", set()),
        ("record=true", set()),
        ("seeds=[0,1]", set()),
    ],
)
def test_a_change_renews_what_depends_on_it_and_nothing_else(change, changed):
    before, after = ids(), ids(change)
    assert {role for role in before if before[role] != after[role]} == changed


def test_what_a_model_does_not_use_does_not_count():
    assert ids("model=trivial", "device=cuda") == ids("model=trivial")
    assert ids("model=trivial") == ids("model=trivial", "basis=t1", "optimiser=lbfgs")
    assert ids("data=long") == ids("data=long", "data.episode_steps=7")


def test_an_optimiser_under_another_name_is_the_same_fit():
    same = ["optimiser.schedule=cosine", "optimiser.decay=0.0", "optimiser.epochs=1000"]
    assert (
        ids("optimiser=adam_cosine", "optimiser.epochs=1000")["fit"].rpartition("-")[2]
        == ids(*same)["fit"].rpartition("-")[2]
    )


def test_names_can_be_read():
    assert ids("basis=t1", "sequence=joint")["run"].startswith("sip-lagrangian-t1-inverse-adam-joint-")
    assert ids("data.episode_steps=50")["data"].startswith("sip-episodes50-")


def test_a_run_leaves_its_stages_and_is_not_repeated(tmp_path):
    store = Store(tmp_path)
    made = pipeline("basis=t1", "optimiser=least_squares")
    record = execute(made, store)
    card = record.summary["card"]
    assert (card["basis"], card["optimiser"], card["hidden"]) == ("t1", "least_squares", None)
    assert (card["n_train"], card["seeds"]) == (160, [0, 1])
    assert record.summary["median"]["mae_tau"] < 1e-10
    assert {path.name for path in record.folder.iterdir()} == {
        "run.json", "metrics.parquet", "trajectories.parquet", "curves.parquet", "identifiability.parquet",
    }  # fmt: skip
    times = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("run.json")}
    assert len(times) == 3
    again = run_job(compose(tiny("basis=t1", "optimiser=least_squares")).config.model_dump(), str(tmp_path), "")
    assert again["run"] == record.id
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("run.json")} == times


def test_a_controller_adds_its_loops_and_leaves_the_fit_alone(tmp_path):
    base = ["basis=t1", "optimiser=least_squares", "seeds=1"]
    asked = [*base, "control=sip", "task.seconds=2", "record=true"]
    assert ids(*base)["fit"] == ids(*asked)["fit"] and ids(*base)["run"] != ids(*asked)["run"]
    other = pipeline(*asked, "task.mismatch=0.1").control_stage.id
    assert pipeline(*asked).control_stage.id != other and pipeline(*base).control_stage is None
    record = execute(pipeline(*asked), Store(tmp_path))
    assert {"control.parquet", "closed_loops.parquet"} <= {path.name for path in record.folder.iterdir()}
    assert record.summary["card"]["control"] == "sip" and 0 <= record.summary["median"]["success"] <= 1
    assert pipeline(*asked).finished(Store(tmp_path)).id == record.id
    assert len(list(tmp_path.glob("recordings/*/recording.rrd"))) == 1


def test_a_damaged_dataset_is_said_set_aside_and_made_again(tmp_path, capsys):
    store = Store(tmp_path)
    made = pipeline("basis=t1", "optimiser=least_squares")
    record = execute(made, store)
    file = tmp_path / "data" / made.data_stages["data"].id / "data.npz"
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    other = execute(pipeline("basis=t1", "optimiser=lasso"), store)
    told = capsys.readouterr().err
    assert "was damaged" in told and "data.npz" in told
    assert len(told.strip().splitlines()) == 1
    assert file.read_bytes() == whole
    assert other.summary["median"]["mae_tau"] == pytest.approx(record.summary["median"]["mae_tau"], abs=1e-10)


RESUMABLE = {
    "adam": ["basis=t2", "optimiser.epochs=20"],
    "adam in torch": ["basis=t2", "optimiser.epochs=5", "optimiser.engine=torch"],
    "lbfgs": ["basis=t2", "optimiser=lbfgs", "optimiser.iterations=8"],
    "levenberg_marquardt": ["basis=t2", "optimiser=levenberg_marquardt", "optimiser.iterations=8"],
    "two phases": ["basis=t2", "sequence=pretrain", "optimiser.epochs=10", "sequence.initial_angles=5"],
}


class Interrupting:
    """Ctrl-C at the given share of the work."""

    def __init__(self, share):
        self.share, self.heard = share, 0

    def report(self, fraction, text):
        if fraction is not None and 0.05 < fraction < 0.95:
            self.heard += 1
            if fraction >= self.share:
                raise KeyboardInterrupt


@pytest.mark.parametrize("name", RESUMABLE)
def test_ctrl_c_and_resume_give_the_same_bits(name, tmp_path, monkeypatch):
    monkeypatch.setattr(fit, "PAUSE_SECONDS", 0.0)
    monkeypatch.setattr(progress, "_SHORTEST_PAUSE_S", 0.0)
    overrides = RESUMABLE[name]
    whole = execute(pipeline(*overrides), Store(tmp_path / "whole"))

    broken = Store(tmp_path / "broken")
    monkeypatch.setattr(progress, "_listener", progress._Listener(Interrupting(0.6).report))
    with pytest.raises(KeyboardInterrupt):
        execute(pipeline(*overrides), broken)
    working = tmp_path / "broken" / "fits" / ".work"
    assert list(working.glob("*/checkpoint*"))
    rest = Interrupting(2.0)
    monkeypatch.setattr(progress, "_listener", progress._Listener(rest.report))
    resumed = execute(pipeline(*overrides), broken)

    np.testing.assert_array_equal(weights(resumed), weights(whole))
    assert resumed.summary["card"] == whole.summary["card"]
    fits = [record.folder / "curves.parquet" for record in (whole, resumed)]
    assert fits[0].read_bytes() == fits[1].read_bytes()
    assert not list(working.glob("*/checkpoint*"))


def test_two_runs_of_one_configuration_are_equal_to_the_bit(tmp_path):
    made = [execute(pipeline("basis=t2"), Store(tmp_path / name)) for name in ("one", "two")]
    np.testing.assert_array_equal(*map(weights, made))
    metrics = [json.loads((record.folder / "run.json").read_bytes())["files"] for record in made]
    assert metrics[0]["trajectories.parquet"] == metrics[1]["trajectories.parquet"]


def test_a_model_too_wide_for_expressions_is_simulated_by_torch_and_recorded(tmp_path):
    store = Store(tmp_path)
    made = pipeline("basis=t2", "model.hidden=[60,60]", "optimiser.epochs=1", "record=true", "seeds=1")
    record = execute(made, store)
    assert record.summary["card"]["n_parameters"] > 2000
    assert made.finished(store) == record
    assert len(list(tmp_path.glob("recordings/*/run.json"))) == 1
