from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from repro.data.random_force import random_force
from repro.data.recording_file import from_file
from repro.errors import UserError
from repro.mechanics.system import load

SYSTEM = load("sip")
COLUMNS = {
    "time": ["t"],
    "q": ["x", "theta"],
    "qd": ["xd", "thetad"],
    "qdd": ["xdd", "thetadd"],
    "tau": ["f", "torque"],
    "episode": ["run"],
}
DATA = random_force(SYSTEM, seeds=[0], samples=100, episode_steps=20)


@pytest.fixture
def table() -> pd.DataFrame:
    columns = {"t": DATA.time, "run": DATA.episode + 7}
    for role in ("q", "qd", "qdd", "tau"):
        columns |= {name: getattr(DATA, role)[0, :, i] for i, name in enumerate(COLUMNS[role])}
    return pd.DataFrame(columns)


def read(path: Path, **changes):
    return from_file(path, **{"columns": COLUMNS, "coordinates": SYSTEM.coordinates} | changes)


def without(*roles: str) -> dict:
    return {role: names for role, names in COLUMNS.items() if role not in roles}


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_recording_comes_back(table: pd.DataFrame, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"mine.{suffix}"
    table.to_csv(path, index=False) if suffix == "csv" else table.to_parquet(path)
    data = read(path, members=3)
    assert (data.members, data.samples, data.n_train) == (3, 100, 80)
    for role in ("q", "qd", "qdd", "tau"):
        np.testing.assert_allclose(getattr(data, role), np.repeat(getattr(DATA, role), 3, axis=0), rtol=1e-15)
    np.testing.assert_array_equal(data.episode, DATA.episode)
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


def test_without_time_a_time_step_is_enough(table: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    table.to_csv(path, index=False)
    data = read(path, columns=without("time", "episode"), time_step=0.1)
    np.testing.assert_allclose(data.time, 0.1 * np.arange(100))
    assert np.all(data.episode == 0)
    with pytest.raises(UserError, match="time_step"):
        read(path, columns=without("time"))


def test_uneven_sampling_is_a_warning_and_a_wrong_time_step_an_error(table: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    table.loc[3, "t"] += 0.01
    table.to_csv(path, index=False)
    assert "25%" in read(path).provenance["warnings"][0]
    with pytest.raises(UserError, match=r"advances by 0\.04 s"):
        read(path, time_step=0.05)


def write(path: Path, table: pd.DataFrame, damage: str) -> None:
    if damage == "column":
        table = table.drop(columns="thetad")
    elif damage == "nan":
        table.loc[41, "theta"] = np.nan
    elif damage == "text":
        table["theta"] = "north"
    elif damage == "time":
        table.loc[5, "t"] = table.loc[4, "t"]
    elif damage == "rows":
        table = table.iloc[:0]
    elif damage == "one row":
        table = table.iloc[:1]
    table.to_csv(path, index=False)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ("column", "no column 'thetad'; it has t, run, x"),
        ("nan", "column 'theta' has no finite number in data row 42"),
        ("text", "not all numbers"),
        ("time", "must increase"),
        ("rows", "no rows"),
        ("one row", "train_fraction"),
    ],
)
def test_what_is_wrong_with_the_file_is_said(table: pd.DataFrame, tmp_path: Path, damage: str, message: str) -> None:
    path = tmp_path / "mine.csv"
    write(path, table, damage)
    with pytest.raises(UserError, match=message):
        read(path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("mine.xlsx", b"", "must end in .csv or .parquet"),
        ("mine.csv", b"", "cannot be read as csv"),
        ("mine.csv", b"\xff\xfe\x00", "cannot be read as csv"),
        ("mine.parquet", b"PAR1 nonsense", "cannot be read as parquet"),
        ("absent.csv", None, "no such file"),
    ],
)
def test_unreadable_files_are_named(tmp_path: Path, name: str, content: bytes | None, message: str) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UserError, match=message) as error:
        read(path)
    assert name in str(error.value)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (without("tau"), "columns.tau names 0 columns"),
        (COLUMNS | {"q": ["x"]}, "columns.q names 1 columns"),
        (COLUMNS | {"force": ["f"]}, "unknown role 'force'"),
    ],
)
def test_roles_are_checked(table: pd.DataFrame, tmp_path: Path, columns: dict, message: str) -> None:
    path = tmp_path / "mine.csv"
    table.to_csv(path, index=False)
    with pytest.raises(UserError, match=message):
        read(path, columns=columns)
