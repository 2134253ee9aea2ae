"""A recording as the data of a run: checked before, known by its content, and fitted like the simulation it holds."""

import re
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from repro.config.compose import compose
from repro.config.overrides import expand
from repro.config.places import ROOT
from repro.pipeline.finished_run import load_run
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute, run_job
from repro.tracking.store import StageFailed, Store


def written(path: Path) -> Path:
    """A recording of a cart that is pushed by a constant force."""
    rows = [f"{0.1 * k:.1f},{0.005 * k**2},{0.2 * k:.1f},{0.1 * k:.1f},2,1,0" for k in range(40)]
    path.write_text("\n".join(["time,x,theta,xd,thetad,force,torque", *rows]))
    return path


def test_a_recording_that_is_broken_after_it_was_checked_says_what_is_wrong_with_it(tmp_path: Path) -> None:
    recording = written(tmp_path / "mine.csv")
    config = compose(["data=file", f"data.path={recording}", "scale=smoke"]).config
    recording.write_text(recording.read_text().replace("torque", "torq"))
    with pytest.raises(StageFailed, match="torque"):
        run_job(config.model_dump(), outputs=str(tmp_path / "outputs"), command="")


def test_a_recording_is_known_by_its_content_wherever_it_lies(tmp_path: Path) -> None:
    def ids(*options: str) -> list[str]:
        planned = compose(["data=file", *options, "basis=t1"])
        return [stage.id for stage in Pipeline.of(planned.config, planned.command).stages]

    one, two = written(tmp_path / "one.csv"), written(tmp_path / "two.csv")
    first = ids(f"data.path={one}")
    assert ids(f"data.path={two}") == first
    assert ids(f"data.path=[{one},{two}]") == ids(f"data.path=[{two},{one}]") != first
    assert ids(f"data.path={one}", f"data.test_path={two}") not in (first, ids(f"data.path=[{one},{two}]"))
    two.write_text(two.read_text().replace(",2,1,", ",2,1.5,"))
    assert ids(f"data.path={two}") != first


def test_a_systems_samples_give_the_same_fit_from_a_file_without_the_system(tmp_path: Path) -> None:
    """A simulated recording, written out and read back with names and angles alone, is fitted to the same weights."""
    store = Store(tmp_path / "outputs")

    def made(*overrides: str):
        composed = compose(["scale=smoke", "record=false", *overrides])
        return Pipeline.of(composed.config, composed.command)

    model = [
        "model=structured",
        "model.hidden=[4]",
        "optimiser=levenberg_marquardt",
        "optimiser.iterations=8",
        "seeds=1",
    ]
    simulated = execute(made("system=sip", "data.samples=200", "data.episode_steps=50", *model), store)
    data = load_run(simulated.id, root=store.paths.root).data
    names = {"q": ["a", "b"], "qd": ["ad", "bd"], "qdd": ["add", "bdd"], "tau": ["f", "g"]}
    columns = {name: getattr(data, role)[0, :, k] for role, each in names.items() for k, name in enumerate(each)}
    pd.DataFrame({"t": data.time, "run": data.episode} | columns).to_csv(tmp_path / "mine.csv", index=False)
    roles = ",".join(f"{role}:[{','.join(each)}]" for role, each in names.items())
    own = ["data.coordinates.names=[a,b]", "data.coordinates.angles=[b]", "data.coordinates.cyclic=[a]"]
    file = ["data=file", f"data.path={tmp_path / 'mine.csv'}", f"data.columns={{{roles},time:[t],episode:[run]}}", *own]
    recorded = execute(made(*file, *model), store)
    weights = [load_run(run.id, root=store.paths.root).parameters.numpy() for run in (simulated, recorded)]
    np.testing.assert_allclose(weights[1], weights[0], rtol=1e-9)
    medians = [run.summary["median"] for run in (simulated, recorded)]
    assert medians[1]["mae_tau"] == pytest.approx(medians[0]["mae_tau"], rel=1e-9)
    assert recorded.summary["card"]["system"] is None


PUBLISHED = ROOT.parent / "shared" / "data"
COMMANDS = re.findall(
    r"^\.venv/bin/repro run (.+?)$", (ROOT / "docs" / "real-data.md").read_text().replace("\\\n", " "), re.MULTILINE
)
# file as the page calls it -> the collected one, and the names of its columns where it was published
FILES = {
    "characters.csv": ("delan_characters", {}),
    "single_free.csv": ("multiarm_single_free", {}),
    "singlePend.csv": (
        "bystricky_cartpole",
        {"x": "s", "theta": "phi1", "xd": "Ds", "thetad": "Dphi", "force": "u", "xdd": "DDs", "thetadd": "DDphi"},
    ),
    "data_measured.csv": (
        "dfki_pendulum_ddp",
        {"t": "time", "theta": "position", "thetad": "velocity", "tau": "torque"},
    ),
}


@pytest.mark.skipif(not PUBLISHED.is_dir(), reason="the published recordings are not beside the checkout")
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_page_reads_its_recording(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, (collected, columns) in FILES.items():
        if name in command:
            pd.read_csv(PUBLISHED / f"{collected}.csv.gz").rename(columns=columns).to_csv(tmp_path / name, index=False)
    monkeypatch.chdir(tmp_path)
    words = shlex.split(command, comments=True)
    for job in expand([word for word in words if word != "-m"]):
        composed = compose(job)
        assert Pipeline.of(composed.config, composed.command).data_stages["data"].config.sha256


def test_the_page_shows_a_command_for_every_recording() -> None:
    assert all(any(f"data.path={name}" in command for command in COMMANDS) for name in FILES)
