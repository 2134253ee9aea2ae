"""A recording read from a file is the data that were written to it, and what is wrong with a file is one line."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from simulated import random_force

from repro.data.data_options import Columns, OwnCoordinates, RecordingFile, Units
from repro.data.recording_file import from_file
from repro.errors import UserError
from repro.mechanics.system import load

SYSTEM = load("sip")
COLUMNS = {
    "time": ("t",),
    "q": ("x", "theta"),
    "qd": ("xd", "thetad"),
    "qdd": ("xdd", "thetadd"),
    "tau": ("f", "torque"),
    "episode": ("run",),
}
DATA = random_force(SYSTEM, seeds=[0], samples=100, episode_steps=20)


@pytest.fixture
def table() -> pd.DataFrame:
    columns = {"t": DATA.time, "run": DATA.episode + 7}
    for role in ("q", "qd", "qdd", "tau"):
        columns |= {name: getattr(DATA, role)[0, :, i] for i, name in enumerate(COLUMNS[role])}
    return pd.DataFrame(columns)


def read(path: Path | list[Path], *, columns=COLUMNS, members: int = 1, **options):
    paths = tuple(map(str, path)) if isinstance(path, list) else str(path)
    return from_file(RecordingFile("file", paths, Columns(**columns), **options), SYSTEM, members=members)


def without(*roles: str) -> dict[str, tuple[str, ...]]:
    return {role: names for role, names in COLUMNS.items() if role not in roles}


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_recording_comes_back(table: pd.DataFrame, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"mine.{suffix}"
    table.to_csv(path, index=False) if suffix == "csv" else table.to_parquet(path)
    data = read(path, members=3, train_fraction=0.7)
    for role in ("q", "qd", "qdd", "tau"):
        np.testing.assert_array_equal(getattr(data, role), np.repeat(getattr(DATA, role), 3, axis=0))
    assert data.n_train == 70
    np.testing.assert_array_equal(data.episode, DATA.episode)
    np.testing.assert_array_equal(data.time, DATA.time)
    assert data.time_step == pytest.approx(0.04)
    assert data.provenance["warnings"] == []


def test_missing_accelerations_are_differenced_with_a_warning(table: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    table.to_csv(path, index=False)
    data = read(path, columns=without("qdd"))
    inside = np.flatnonzero(np.diff(DATA.episode) == 0)
    forward = (DATA.qd[:, inside + 1] - DATA.qd[:, inside]) / 0.04
    np.testing.assert_allclose(data.qdd[:, inside], forward, rtol=1e-9)
    assert "differenced" in data.provenance["warnings"][0]


def test_velocities_of_a_parabola_are_exact_at_uneven_stamps(tmp_path: Path) -> None:
    time = np.cumsum([0.0, 0.02, 0.013, 0.03, 0.021, 0.02, 0.017, 0.02, 0.02, 0.019, 0.02, 0.02])
    table = pd.DataFrame({"t": time, "x": 1 + 2 * time - 3 * time**2, "theta": 0.5 * time**2, "f": np.ones(12)})
    table.to_csv(tmp_path / "mine.csv", index=False)
    data = read(tmp_path / "mine.csv", columns={"time": ("t",), "q": ("x", "theta"), "tau": ("f",)})
    np.testing.assert_allclose(data.qd[0], np.stack([2 - 6 * time, time], axis=1), atol=1e-12)
    np.testing.assert_allclose(data.qdd[0], np.broadcast_to([-6.0, 1.0], (12, 2)), atol=1e-9)
    np.testing.assert_array_equal(data.tau[0], np.broadcast_to([1.0, 0.0], (12, 2)))  # the force drives the cart
    assert "differenced from q" in data.provenance["warnings"][0]


def test_without_time_a_time_step_is_enough(table: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    table.to_csv(path, index=False)
    data = read(path, columns=without("time", "qd", "qdd"), time_step=0.1)
    np.testing.assert_allclose(data.time, 0.1 * np.arange(100))
    with pytest.raises(UserError, match="time_step"):
        read(path, columns=without("time"))


def test_uneven_sampling_is_a_warning_and_a_wrong_time_step_an_error(table: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    table.loc[3, "t"] += 0.01
    table.to_csv(path, index=False)
    assert "25%" in read(path).provenance["warnings"][0]
    with pytest.raises(UserError, match=r"advances by 0\.04 s"):
        read(path, time_step=0.05)


def damaged(table: pd.DataFrame, damage: str) -> pd.DataFrame:
    if damage == "column":
        table = table.drop(columns="thetad")
    elif damage == "nan":
        table.loc[41, "theta"] = np.nan
    elif damage == "text":
        table["theta"] = table["theta"].astype(object)
        table.loc[7, "theta"] = "north"
    elif damage == "thousands":
        table["f"] = [f"{1000 * value:,.2f}" for value in table["f"]]
    elif damage == "flags":
        table["f"] = table["f"] > 0
    elif damage == "time":
        table.loc[5, "t"] = table.loc[4, "t"]
    elif damage == "order":
        table = table.sort_values("theta")
    elif damage == "rows":
        table = table.iloc[:0]
    elif damage == "one row":
        table = table.iloc[:1]
    return table


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ("column", r"no column 'thetad' \(did you mean thetadd\?\); it has t, run, x"),
        ("nan", r"column 'theta' has no finite number in data row 42 .*data\.missing=drop"),
        ("text", "column 'theta' holds 'north' in data row 8, which is no number"),
        ("thousands", "column 'f' holds '.*,.*' in data row .*, which is no number"),
        ("flags", "column 'f' holds true and false, not numbers"),
        ("time", "must increase .* data row 6"),
        ("order", r"must increase .*columns\.episode"),
        ("rows", "no rows"),
        ("one row", "train_fraction"),
    ],
)
def test_what_is_wrong_with_the_file_is_said(table: pd.DataFrame, tmp_path: Path, damage: str, message: str) -> None:
    path = tmp_path / "mine.csv"
    damaged(table, damage).to_csv(path, index=False)
    columns = without("episode") if damage == "order" else COLUMNS
    with pytest.raises(UserError, match=message) as error:
        read(path, columns=columns)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("mine.xlsx", b"PK\x03\x04\x00", "neither text nor Parquet"),
        ("mine.csv", b"", "no rows"),
        ("mine.csv", b"\xff\xfe\x00", "damaged UTF-16"),
        ("mine.csv", b"1,2\n3,4\n", "no line of column names"),
        ("mine.csv", b"t,x\n1,2\n1,2,3\n", "cannot be read as text .*saw 3"),
        ("mine.csv", b"t,x\n1,2,3\n1,2,3\n", "more values than the 2 column names"),
        ("mine.csv.gz", b"\x1f\x8b\x08\x00", "cannot be read"),
        ("mine.parquet", b"PAR1 nonsense", "cannot be read as Parquet"),
        ("absent.csv", None, "no such file"),
        ("", None, "folder has no file"),
    ],
)
def test_unreadable_files_are_named(tmp_path: Path, name: str, content: bytes | None, message: str) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UserError, match=message) as error:
        read(path)
    assert name in str(error.value)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"columns": COLUMNS | {"q": ("x",)}}, "columns.q names 1 columns"),
        ({"columns": COLUMNS | {"q": ("x", "x")}}, "'x' is named twice, in columns.q and columns.q"),
        ({"columns": COLUMNS | {"tau": ("f", "torque", "xd")}}, r"data\.driven="),
        ({"driven": ("cart",)}, r"data\.driven = \['cart'\]: choose from the coordinates x, theta"),
        ({"units": Units(q=("m",))}, "needs one unit for each of the 2 columns"),
        ({"units": Units(q=("m", "furlong"))}, "'furlong' is not known"),
        ({"units": Units(tau=(0.0, 1.0))}, "no factor"),
        ({"test_episodes": (7, "later")}, r"\['later'\]: there are the episodes 7, 8, 9, 10, 11"),
        ({"test_episodes": (7, 8, 9, 10, 11)}, "nothing is left to learn from"),
        ({"coordinates": OwnCoordinates(("x", "theta"), angles=("phi",))}, "coordinates.angles"),
        ({"coordinates": OwnCoordinates(("x", "x"))}, "give each name once"),
        ({"coordinates": OwnCoordinates(("x", "theta"), units=("m",))}, "needs one per name"),
    ],
)
def test_options_that_do_not_fit_the_file(table: pd.DataFrame, tmp_path: Path, changes: dict, message: str) -> None:
    path = tmp_path / "mine.csv"
    table.to_csv(path, index=False)
    with pytest.raises(UserError, match=message):
        read(path, **changes)


def test_every_file_is_an_episode_and_some_are_for_testing(table: pd.DataFrame, tmp_path: Path) -> None:
    folder = tmp_path / "trials"
    folder.mkdir()
    for number, part in table.groupby("run"):  # 7 to 11: the names sort as numbers, 7, 8, ..., 11
        part.assign(t=part["t"] - part["t"].iloc[0]).to_csv(folder / f"trial_{number}.csv", index=False)
    (folder / "._trial_7.csv").write_text("of another system")
    data = read(folder, columns=without("episode"), train_fraction=0.5)
    np.testing.assert_array_equal(data.q, DATA.q)
    np.testing.assert_array_equal(data.episode, DATA.episode)
    np.testing.assert_allclose(data.time, DATA.time, atol=1e-12)
    assert data.n_train == 50

    chosen = read(folder, columns=without("episode"), test_episodes=("trial_8",))
    np.testing.assert_array_equal(chosen.test.q, DATA.q[:, 20:40])
    np.testing.assert_array_equal(chosen.train.q, np.delete(DATA.q, np.s_[20:40], axis=1))
    assert np.all(np.diff(chosen.time) > 0)

    files = [folder / "trial_7.csv", folder / "trial_9.csv"]
    apart = read(files, columns=without("episode"), test_path=str(folder / "trial_11.csv"))
    np.testing.assert_array_equal(apart.test.q, DATA.q[:, 80:])
    assert apart.n_train == 40


def test_units_are_converted(table: pd.DataFrame, tmp_path: Path) -> None:
    table["t"] *= 1000
    for name in ("theta", "thetad", "thetadd"):
        table[name] = np.degrees(table[name])
    table["f"] /= 0.25
    table.to_csv(tmp_path / "mine.csv", index=False)
    units = Units(q=("m", "deg"), qd=("m/s", "deg/s"), qdd=("m/s^2", "deg"), time=("ms",), tau=(0.25, "N m"))
    data = read(tmp_path / "mine.csv", units=units)
    for role in ("q", "qd", "qdd", "tau"):
        np.testing.assert_allclose(getattr(data, role), getattr(DATA, role), atol=1e-12)
    np.testing.assert_allclose(data.time, DATA.time, atol=1e-12)


def test_rows_without_a_number_are_left_out_on_demand(table: pd.DataFrame, tmp_path: Path) -> None:
    table.loc[[30, 32], "theta"] = np.nan  # row 31 stays alone, and has no difference
    table.to_csv(tmp_path / "mine.csv", index=False)
    data = read(tmp_path / "mine.csv", missing="drop", columns=without("qdd"))
    kept = np.delete(np.arange(100), [30, 31, 32])
    np.testing.assert_array_equal(data.q, DATA.q[:, kept])
    assert data.episode[30] == data.episode[29] + 1
    said = " ".join(data.provenance["warnings"])
    assert "2 of 100 rows have no number" in said
    assert "1 rows are left out" in said


def test_a_gap_ends_an_episode_and_a_wrapped_angle_is_made_continuous(table: pd.DataFrame, tmp_path: Path) -> None:
    table.loc[50:, "t"] += 1.0
    table["theta"] = (table["theta"] + 3 + np.pi) % (2 * np.pi) - np.pi
    table.to_csv(tmp_path / "mine.csv", index=False)
    data = read(tmp_path / "mine.csv")
    assert data.episode[50] == data.episode[49] + 1
    inside = np.diff(data.episode) == 0
    assert np.abs(np.diff(data.q[0, :, 1])[inside]).max() < 2
    np.testing.assert_allclose(np.cos(data.q[0, :, 1]), np.cos(DATA.q[0, :, 1] + 3), atol=1e-9)
    said = " ".join(data.provenance["warnings"])
    assert "1 gaps of up to 1.04 s" in said
    assert "modulo a turn" in said


def test_coordinates_of_ones_own(tmp_path: Path) -> None:
    time = 0.02 * np.arange(60)
    pd.DataFrame({"t": time, "a": np.sin(time), "b": time, "u": np.cos(7 * time)}).to_csv(tmp_path / "arm.csv")
    own = OwnCoordinates(("shoulder", "slide"), angles=("shoulder",), cyclic=("slide",))
    columns = Columns(time=("t",), q=("a", "b"), tau=("u",))
    source = RecordingFile("file", str(tmp_path / "arm.csv"), columns, coordinates=own, driven=("slide",))
    data = from_file(source, None)
    assert [(c.name, c.unit, c.is_angle, c.cyclic) for c in data.coordinates] == [
        ("shoulder", "rad", True, False),
        ("slide", "m", False, True),
    ]
    np.testing.assert_array_equal(data.tau[0, :, 0], 0.0)
    np.testing.assert_array_equal(data.tau[0, :, 1], np.cos(7 * time))
    with pytest.raises(UserError, match=r"columns\.tau names 1 columns .* data\.driven=\[shoulder\]"):
        from_file(RecordingFile("file", source.path, columns, coordinates=own), None)


@pytest.mark.parametrize("labels", ["savitzky_golay", "smoothed"])
def test_noisy_positions_are_smoothed_on_demand(tmp_path: Path, labels: str) -> None:
    time = 0.01 * np.arange(400)
    exact = np.stack([0.4 * np.sin(2 * time), np.cos(3 * time)], axis=1)
    noisy = exact + 1e-3 * np.random.default_rng(0).standard_normal(exact.shape)
    columns = {"t": time, "x": noisy[:, 0], "theta": noisy[:, 1], "f": np.sin(time)}
    pd.DataFrame(columns).to_csv(tmp_path / "mine.csv", index=False)
    roles = {"time": ("t",), "q": ("x", "theta"), "tau": ("f",)}
    data, raw = (read(tmp_path / "mine.csv", columns=roles, labels=each, members=2) for each in (labels, "recorded"))
    error, raw_error = (np.abs(each.qdd[1] + exact * [4, 9])[20:-20].mean() for each in (data, raw))
    assert error < 0.05 * raw_error
    assert data.measurement is not None and data.measurement.qd is None
    np.testing.assert_array_equal(data.measurement.q[1], noisy)
