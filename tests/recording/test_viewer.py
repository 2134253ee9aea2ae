import socket
import struct
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from repro.commands import view
from repro.commands.arguments import parsed
from repro.errors import UserError
from repro.recording import viewer
from repro.recording.contents import DrawnMotion, DrawnShape, RunRecording
from repro.recording.writer import write_recording
from repro.tracking.record import Identity, Record, StageOutcome


@pytest.fixture
def outputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A store with the recordings of three runs, two of them of like names."""
    for recording, run in {
        "sip-recording-11": "sip-t2-aa1",
        "sip-recording-22": "sip-t2-aa2",
        "dip-recording-33": "dip-t2-bb1",
    }.items():
        folder = tmp_path / viewer.KIND / recording
        folder.mkdir(parents=True)
        identity = Identity(upstream={"run": run})
        Record(recording, viewer.KIND, recording, StageOutcome.OK, folder, identity).write()
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))
    return tmp_path


@pytest.mark.parametrize("name", ["dip-t2-bb1", "dip", "dip-recording-33", "dip-rec", "bb1", "33"])
def test_a_recording_is_found_by_run_or_recording_or_their_beginning(outputs, name):
    assert viewer.find_recording(name, outputs) == outputs / "recordings" / "dip-recording-33" / "recording.rrd"


def test_a_whole_id_wins_over_a_longer_one_that_it_begins(outputs):
    folder = outputs / viewer.KIND / "dip-recording-44"
    folder.mkdir()
    Record(
        "dip-recording-44", viewer.KIND, "", StageOutcome.OK, folder, Identity(upstream={"run": "dip-t2-bb11"})
    ).write()
    assert viewer.find_recording("dip-t2-bb1", outputs).parent.name == "dip-recording-33"


def test_an_ambiguous_beginning_lists_what_it_begins(outputs):
    with pytest.raises(UserError, match="2 recordings") as caught:
        view.main(parsed("view", ["sip"]))
    assert "sip-recording-11" in str(caught.value)
    assert "dip" not in str(caught.value)


def test_an_unknown_run_lists_what_there_is(outputs):
    with pytest.raises(UserError, match="no recording of a run 'chain'") as caught:
        view.main(parsed("view", ["chain"]))
    assert "dip-recording-33" in str(caught.value)


def test_an_empty_store_says_how_to_fill_it(tmp_path):
    with pytest.raises(UserError, match="repro reproduce"):
        viewer.find_recording("sip", tmp_path)


def test_a_path_is_taken_as_it_is(tmp_path):
    path = tmp_path / "mine.rrd"
    with pytest.raises(UserError, match=r"no file .*mine\.rrd"):
        viewer.find_recording(str(path), tmp_path)
    path.touch()
    assert viewer.find_recording(str(path), tmp_path) == path


def test_without_a_display_the_other_ways_are_named(outputs, monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(UserError, match=r"no display.*--web.*--screenshot"):
        view.main(parsed("view", ["dip"]))


def test_a_port_in_use_is_passed_over():
    with socket.socket() as taken:
        taken.bind((viewer.LOCAL, 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert viewer.free_port(port) > port


def test_the_command_line_of_the_viewer_exists():
    assert Path(viewer.command_of()[0]).is_file()


def test_a_viewer_that_ends_before_it_has_drawn_names_the_driver(outputs, tmp_path, monkeypatch):
    class Ended:
        def open(self, paths: list[str]) -> None:
            raise ConnectionError("transport error")

    monkeypatch.setattr(viewer, "_viewer", lambda *arguments, quiet: nullcontext())
    monkeypatch.setattr(viewer, "_answer", lambda *arguments: Ended())
    with pytest.raises(UserError, match=r"the viewer ended before it had drawn .* needs a Vulkan driver"):
        viewer.screenshot(tmp_path / "sip.rrd", tmp_path / "picture.png", at=1.0)
    assert not (tmp_path / "picture.png").exists()


@pytest.mark.slow
def test_a_picture_needs_no_display(tmp_path):
    time = np.arange(30) * 0.04
    points = np.stack([np.zeros((30, 2)), np.stack([np.sin(time), np.cos(time)], axis=-1)], axis=1)
    plant = DrawnMotion(np.stack([time, time], axis=-1), {"H": time}, [DrawnShape("link", points)])
    recording = RunRecording(
        "r", "r", {}, time, [("theta", "rad")], plant, {"seed 0": plant}, {"theta": time}, {"supplied": time}
    )
    write_recording(tmp_path / "r.rrd", recording)
    picture = tmp_path / "r.png"
    try:
        assert view.main(parsed("view", [str(tmp_path / "r.rrd"), "--screenshot", str(picture), "--at", "0.5"])) == 0
    except UserError as error:
        if "Vulkan" not in str(error):
            raise
        pytest.skip(str(error))
    content = picture.read_bytes()
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", content[16:24]) == (1600, 900)
