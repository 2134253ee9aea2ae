import subprocess
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader
from rerun.error_utils import RerunWarning

from repro.errors import UserError
from repro.recording import palette
from repro.recording.chart import LINKED_AXES, Chart
from repro.recording.contents import DrawnMotion, DrawnShape, LearningCurve, RunRecording
from repro.recording.layout import layout_of
from repro.recording.viewer import command_of, environment
from repro.recording.writer import card_page, read_recording, write_recording

LENGTH, GRAVITY, MASS = 0.5, 9.8, 0.2


def shapes_of(cart: np.ndarray, tip: np.ndarray) -> list[DrawnShape]:
    block = DrawnShape("cart", cart[:, None], np.zeros(len(cart)), (0.14, 0.05))
    return [block, DrawnShape("link", np.stack([cart, tip], axis=1)), DrawnShape("arrow", cart[:, None], block.turn)]


def swing(time: np.ndarray, amplitude: float) -> DrawnMotion:
    """A cart to and fro, its link about the upright; all numbers irregular, so that equality means something."""
    x, theta = amplitude * np.sin(1.3 * time), 2.0 * amplitude * np.cos(2.1 * time)
    rates = 1.3 * amplitude * np.cos(1.3 * time), -4.2 * amplitude * np.sin(2.1 * time)
    potential = MASS * GRAVITY * LENGTH * np.cos(theta)
    kinetic = MASS * (LENGTH * rates[1]) ** 2 / 2
    cart = np.stack([x, np.zeros_like(x)], axis=-1)
    tip = cart + LENGTH * np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    energies = {"T": kinetic, "V": potential, "H": kinetic + potential}
    return DrawnMotion(np.stack([x, theta, *rates], axis=-1), energies, shapes_of(cart, tip))


def example(steps: int = 50, models: int = 2) -> RunRecording:
    time = np.arange(steps) * 0.04
    rollouts = {f"seed {number}": swing(time, 0.5 + 0.01 * number) for number in range(1, models + 1)}
    epochs = np.arange(0, 500, 7)
    return RunRecording(
        run="sip-lagrangian-9f3c2a81bd",
        title="SIP, T2, 2 seeds",
        card={"system": "sip", "Fit": {"rate": 0.01, "steps": {"first": 3}}, "Metrics": {"mae": 1 / 3}},
        time=time,
        coordinates=(("x", "m"), ("theta", "rad")),
        plant=swing(time, 0.5),
        models=rollouts,
        forces={"x": np.sin(7.0 * time)},
        inputs={"force": np.sin(7.0 * time)},
        power={"supplied": np.cos(time), "dH/dt": np.cos(time) / 3},
        curves={"log10 loss": LearningCurve(epochs, {label: -np.log10(1.0 + epochs) for label in rollouts})},
        obstacle=(0.6, 0.4, 0.1),
    )


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunRecording, Path]:
    path = tmp_path_factory.mktemp("recording") / "recording.rrd"
    recording = example()
    write_recording(path, recording)
    return recording, path


def chunks(path: Path) -> dict[str, list]:
    found: dict[str, list] = {}
    for chunk in RrdReader(path).stream().to_chunks():
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def column(batches: list, name: str, width: int) -> np.ndarray:
    batch = next(batch for batch in batches if name in batch.schema.names)
    values = batch[name].flatten()
    while hasattr(values, "flatten") and str(values.type).startswith("fixed_size_list"):
        values = values.flatten()
    return values.to_numpy().reshape(-1, width)


def test_every_value_returns_to_the_last_bit_and_every_time_to_a_nanosecond(written):
    recording, path = written
    tracks = read_recording(path)
    rollouts = [recording.plant, *recording.models.values()]
    expected = {f"energy/{name}": [rollout.energies[name] for rollout in rollouts] for name in "TVH"}
    for column_number, entity in enumerate(("state/x", "state/theta", "state/xd", "state/thetad")):
        expected[entity] = [rollout.state[:, column_number] for rollout in rollouts]
    expected |= {"force": [recording.forces["x"]], "power": list(recording.power.values())}
    for entity, lines in expected.items():
        assert np.array_equal(tracks[entity].values, np.stack(lines, axis=-1)), entity
        assert np.abs(tracks[entity].at - recording.time).max() < 1e-9
    curve = recording.curves["log10 loss"]
    assert np.array_equal(tracks["learning/log10_loss"].values, np.stack(list(curve.values.values()), axis=-1))
    assert np.array_equal(tracks["learning/log10_loss"].at, curve.step)
    assert tracks.keys() == {*expected, "learning/log10_loss"}


def test_lines_are_named_with_their_unit(written):
    tracks = read_recording(written[1])
    assert tracks["energy/H"].names == ("H plant [J]", "H seed 1 [J]", "H seed 2 [J]")
    assert tracks["state/thetad"].names[0] == "dθ/dt plant [rad/s]"
    assert tracks["force"].names == ("force [N]",)


def test_a_motion_with_errors_lies_within_its_band():
    recording = example(models=1)
    (model,) = recording.models.values()
    spread = np.abs(model.state) / 10
    layout = layout_of(replace(recording, models={"seed 1": replace(model, spread=spread)}))
    for number, chart in enumerate([*layout.coordinates, *layout.rates]):
        lines = dict(zip(chart.names, chart.lines.values(), strict=True))
        above, below, _, own = lines.values()  # the edges first, so that they are drawn below the motion
        assert [name.partition("seed 1 ")[2].partition(" [")[0] for name in lines][:2] == ["+ 2 s.e.", "- 2 s.e."]
        np.testing.assert_allclose(above - own, 2 * spread[:, number])
        np.testing.assert_allclose(own - below, 2 * spread[:, number])


def test_every_input_has_a_line_in_the_chart_of_its_unit():
    forces = {name: np.linspace(0.0, slope, 50) for name, slope in (("x", 1.0), ("y", 2.0), ("theta", 3.0))}
    still = DrawnMotion(np.zeros((50, 6)), {"H": np.zeros(50)}, [DrawnShape("link", np.ones((50, 2, 2)))])
    coordinates = (("x", "m"), ("y", "m"), ("theta", "rad"))
    recording = replace(example(), coordinates=coordinates, plant=still, models={}, curves={}, forces=forces)
    charts = {chart.path: chart.names for chart in layout_of(recording).inputs}
    assert charts["force"] == ["force x [N]", "force y [N]"]
    assert charts["torque"] == ["torque [N m]"]


def test_the_title_of_a_further_chart_is_short_and_its_meaning_stands_in_the_legend():
    charts = {"solver time": ("ms", np.ones(50)), "fallback: 1 second try, 2 last plan, 3 none": ("", np.zeros(50))}
    time, fallback = layout_of(replace(example(), charts=charts)).further
    assert (time.path, time.title, time.names, time.legend) == (
        "further/solver_time", "solver time", ["solver time [ms]"], False
    )  # fmt: skip
    assert (fallback.path, fallback.title, fallback.legend) == ("further/fallback", "fallback", True)
    assert fallback.names == ["1 second try, 2 last plan, 3 none"]
    assert all(len(str(chart.view().name)) <= 24 for chart in (time, fallback))  # of half the left column, 300 px wide


def test_the_file_names_its_run_holds_its_layout_and_is_sound(written):
    recording, path = written
    reader = RrdReader(path)
    assert [store.recording_id for store in reader.recordings()] == [recording.run]
    assert {store.application_id for store in [*reader.recordings(), *reader.blueprints()]} == {"repro"}
    assert len(reader.blueprints()) == 1
    command = command_of("rrd", "verify", str(path))
    verdict = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=60, check=True)
    assert verdict.stdout + verdict.stderr == "1 file verified without error.\n"


def test_the_drawing_ends_where_the_points_are_with_y_turned_down(written):
    recording, path = written
    found = chunks(path)
    for name, rollout in {"plant": recording.plant, "seed_1": recording.models["seed 1"]}.items():
        place = column(found[f"/scene/{name}/link1"], "Transform3D:translation", 3)
        turn = column(found[f"/scene/{name}/link1"], "Transform3D:quaternion", 4)
        angle = 2 * np.arctan2(turn[:, 2], turn[:, 3])
        tip = place[:, :2] + LENGTH * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        assert np.allclose(tip, rollout.shapes[1].points[:, 1] * [1, -1], atol=1e-6)
        cart = column(found[f"/scene/{name}/cart"], "Transform3D:translation", 3)
        assert np.allclose(cart[:, :2], rollout.shapes[1].points[:, 0] * [1, -1], atol=1e-6)
    upright = recording.plant.shapes[1].points[:, 1, 1].argmax()
    assert column(found["/scene/plant/link1"], "Transform3D:quaternion", 4)[upright, 2] < 0


def test_the_linked_time_axes_span_the_whole_motion_with_room_for_the_label_of_its_end(written):
    recording, path = written
    reader = RrdReader(path)
    found = {chunk.entity_path: chunk for chunk in reader.stream(store=reader.blueprints()[0]).to_chunks()}
    axis = found[f"/view/{LINKED_AXES}/TimeAxis"].to_record_batch()["TimeAxis:view_range"][0][0].as_py()
    start, end = axis["start"] / 1e9, axis["end"] / 1e9
    length = recording.time[-1] - recording.time[0]
    assert recording.time[0] - 0.1 * length < start < recording.time[0]
    assert recording.time[-1] < end < recording.time[-1] + 0.1 * length


def test_the_card_is_in_the_file_as_text_and_as_properties(written):
    found = chunks(written[1])
    text = found["/run_card"][0]["TextDocument:text"][0].as_py()[0]
    assert "| steps.first | 3 |" in text
    assert "| Metrics |  |\n| --- | --- |\n| mae | 0.3333 |" in text
    assert found["/__properties/run"][0]["Fit.rate"][0].as_py() == [0.01]


def test_a_long_rollout_stays_small(tmp_path):
    models = 2
    write_recording(tmp_path / "long.rrd", example(steps=10_000, models=models))
    assert (tmp_path / "long.rrd").stat().st_size < 2e6 * (1 + models)


def test_a_model_that_diverges_is_a_gap_and_hides_nothing(tmp_path):
    recording = example()
    lost = recording.models["seed 1"]
    for array in (lost.state, *(shape.points for shape in lost.shapes), *lost.energies.values()):
        array[20:30], array[30:] = 1e300, np.nan
    write_recording(tmp_path / "diverged.rrd", recording)
    assert np.isnan(read_recording(tmp_path / "diverged.rrd")["energy/H"].values[30:, 1]).all()
    turn = column(chunks(tmp_path / "diverged.rrd")["/scene/seed_1/link1"], "Transform3D:quaternion", 4)
    assert np.allclose(np.linalg.norm(turn, axis=-1), 1.0)


def test_a_view_opens_to_the_reference_however_far_another_line_runs():
    lines = {"plant": np.array([0.0, 1.0]), "near": np.array([0.1, 1.2]), "lost": np.array([1e300, np.nan])}
    chart = Chart("energy/H", "H", "H", "J", lines, dict.fromkeys(lines, palette.PLANT), reference="plant")
    low, high = chart.opening_range()
    assert low < 0.0
    assert 1.2 < high < 2.0


@pytest.mark.parametrize("labels", [("plant",), ("a b", "a_b")])
def test_labels_that_share_a_place_in_the_picture_are_refused(labels):
    with pytest.raises(ValueError, match="labels must differ"):
        replace(example(), models={label: swing(np.arange(50) * 0.04, 0.5) for label in labels})


@pytest.mark.parametrize(
    "change",
    [
        {"forces": {"x": np.zeros(49)}},
        {"power": {"supplied": np.zeros(7)}},
        {"models": {"short": swing(np.arange(9) * 0.04, 0.5)}},
        {"curves": {"loss": LearningCurve(np.arange(3), {"seed 1": np.zeros(2)})}},
    ],
)
def test_arrays_of_another_length_are_refused(change, tmp_path):
    with pytest.raises((ValueError, RerunWarning), match=r"same length|same shape"):
        write_recording(tmp_path / "recording.rrd", replace(example(), **change))
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("part", [0.0, 0.3, 0.999])
def test_a_cut_file_is_refused_by_name(written, tmp_path, part):
    whole = written[1].read_bytes()
    cut = tmp_path / "cut.rrd"
    cut.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(UserError, match=r"cut\.rrd is not a whole recording"):
        read_recording(cut)


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(UserError, match=r"none\.rrd"):
        read_recording(tmp_path / "none.rrd")


def test_a_failed_write_leaves_neither_name_nor_litter(tmp_path, monkeypatch):
    def fail(path: Path, expected: set[str], rows: int) -> None:
        raise OSError("the disk is gone")

    write_recording(tmp_path / "recording.rrd", example())
    before = (tmp_path / "recording.rrd").read_bytes()
    monkeypatch.setattr("repro.recording.writer._check", fail)
    with pytest.raises(OSError, match="gone"):
        write_recording(tmp_path / "recording.rrd", example())
    assert [path.name for path in tmp_path.iterdir()] == ["recording.rrd"]
    assert (tmp_path / "recording.rrd").read_bytes() == before


def test_a_cell_cannot_break_its_table():
    page = card_page("t", {"note": "a|b\nc", "nothing": None, "empty": [], "many": [1, 2.0]})
    assert "| note | a\\|b c |\n| nothing | – |\n| empty |  |\n| many | 1, 2 |" in page


def luminance(colour: palette.Colour) -> float:
    """Relative luminance of sRGB, WCAG 2.2."""
    parts = np.array(colour) / 255
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("colour", [palette.PLANT, palette.FORCE, palette.OBSTACLE, *palette.MODELS])
@pytest.mark.parametrize("background", [(13, 16, 17), (255, 255, 255)])
def test_every_colour_stands_out_on_the_dark_and_the_light_theme(colour, background):
    dark, light = sorted((luminance(colour), luminance(background)))
    assert (light + 0.05) / (dark + 0.05) > 3.0


def test_roles_are_told_apart():
    for one, other in combinations([palette.PLANT, *palette.MODELS[:4]], 2):
        assert np.linalg.norm(np.subtract(one, other)) > 60
    assert len(set(palette.colours([f"seed {number}" for number in range(10)]).values())) == 10
