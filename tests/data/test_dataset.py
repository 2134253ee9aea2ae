import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from simulated import free_motion, random_force

from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.library.datasets import for_members
from repro.mechanics.system import load


@pytest.fixture
def data() -> Dataset:
    return free_motion(load("sip"), seeds=[0, 1], initial_angles=5, steps=4)


def assert_equal(one: Dataset, other: Dataset) -> None:
    for name in ("q", "qd", "qdd", "tau", "time", "episode", "energy"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), strict=True)
    for name in ("n_train", "coordinates", "time_step", "provenance"):
        assert getattr(one, name) == getattr(other, name)


def test_what_is_saved_is_loaded(data: Dataset, tmp_path: Path) -> None:
    data.save(tmp_path / "data")
    assert_equal(Dataset.load(tmp_path / "data"), data)


def test_unknown_energy_stays_unknown(data: Dataset, tmp_path: Path) -> None:
    replace(data, energy=None).save(tmp_path)
    assert Dataset.load(tmp_path).energy is None


def test_units_are_written_beside_the_arrays(data: Dataset, tmp_path: Path) -> None:
    data.save(tmp_path)
    units = json.loads((tmp_path / "data.json").read_text())["units"]
    assert units["q"] == ["m", "rad"]
    assert units["qdd"] == ["m/s^2", "rad/s^2"]
    assert units["tau"] == ["N", "N m"]
    assert units["energy"] == "J"


def test_train_and_test_are_disjoint_and_complete(data: Dataset) -> None:
    train, test = data.train, data.test
    assert (train.samples, test.samples, train.members) == (16, 4, 2)
    assert (train.n_train, test.n_train) == (16, 0)
    for name in ("q", "qd", "qdd", "tau", "energy"):
        joined = np.concatenate([getattr(train, name), getattr(test, name)], axis=1)
        np.testing.assert_array_equal(joined, getattr(data, name))
    np.testing.assert_array_equal(np.append(train.episode, test.episode), data.episode)


@pytest.mark.parametrize("damage", ["truncated", "emptied", "garbled", "short"])
def test_a_damaged_file_is_named(data: Dataset, tmp_path: Path, damage: str) -> None:
    data.save(tmp_path)
    path = tmp_path / "data.npz"
    content = path.read_bytes()
    if damage == "truncated":
        path.write_bytes(content[: len(content) // 2])
    elif damage == "emptied":
        path.write_bytes(b"")
    elif damage == "garbled":
        middle = 200
        path.write_bytes(content[:middle] + bytes(255 - byte for byte in content[middle : middle + 8]) + content[208:])
    else:
        np.savez(path, q=data.q)
    with pytest.raises(UserError, match=r"data\.npz is damaged"):
        Dataset.load(tmp_path)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"coordinates": []}'])
def test_a_damaged_description_is_an_error(data: Dataset, tmp_path: Path, text: str) -> None:
    data.save(tmp_path)
    (tmp_path / "data.json").write_text(text)
    with pytest.raises(UserError, match="is damaged"):
        Dataset.load(tmp_path)


@pytest.mark.parametrize("name", ["data.npz", "data.json"])
def test_a_missing_file_is_named(data: Dataset, tmp_path: Path, name: str) -> None:
    data.save(tmp_path)
    (tmp_path / name).unlink()
    with pytest.raises(UserError, match=f"{name} is missing"):
        Dataset.load(tmp_path)


@pytest.mark.parametrize(
    "wrong", [{"tau": np.zeros((2, 20, 1))}, {"time": np.zeros(19)}, {"energy": np.zeros(20)}, {"n_train": 21}]
)
def test_arrays_that_do_not_fit_are_refused(data: Dataset, wrong: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        replace(data, **wrong)


def test_members_are_taken_with_all_that_belongs_to_them():
    recorded = {"measured": "states", "labels": "differenced"}
    data = random_force(load("sip"), seeds=[0, 1], samples=20, episode_steps=10, **recorded)
    swapped = data.of_members([1, 0, 1])
    assert swapped.members == 3
    for name in ("q", "qd", "qdd", "tau"):
        np.testing.assert_array_equal(getattr(swapped, name), getattr(data, name)[[1, 0, 1]])
    np.testing.assert_array_equal(swapped.measurement.qd, data.measurement.qd[[1, 0, 1]])
    np.testing.assert_array_equal(swapped.time, data.time)
    for_two = for_members(data.of_members([1]), 2)  # as many fits of one recording: each has what the sensors recorded
    np.testing.assert_array_equal(for_two.measurement.q, data.measurement.q[[1, 1]])
