"""The index is what the store holds, whatever happens to its files."""

from __future__ import annotations

import json
import shutil

import pandas as pd
import pytest

from repro.tracking import index


def files(store):
    return sorted(store.paths.index.glob("*.parquet"))


def make(store, stage, numbers):
    return [
        store.compute(stage(a=number), lambda folder, number=number: {"card": {"z": number, "a": [1]}}).id
        for number in numbers
    ]


def ids(store):
    return [entry.id for entry in index.load(store.paths).entries]


def test_what_is_new_is_added_and_nothing_else_is_written(store, stage):
    first = make(store, stage, range(3))
    fresh = index.load(store.paths)
    assert sorted(first) == [entry.id for entry in fresh.entries]
    (base,) = files(store)
    stamp = base.stat().st_mtime_ns
    assert index.load(store.paths) == fresh
    assert files(store) == [base]
    second = make(store, stage, [3])
    assert ids(store) == sorted(first + second)
    _, added = files(store)
    assert base.stat().st_mtime_ns == stamp
    assert list(pd.read_parquet(added)["id"]) == second
    assert list(index.load(store.paths).finished()[second[0]].card.items()) == [("z", 3), ("a", [1])]


def test_many_small_files_become_one(store, stage):
    made = []
    for number in range(12):
        made += make(store, stage, [number])
        assert ids(store) == sorted(made)
        assert len(files(store)) <= 8
    assert sum(len(pd.read_parquet(file)) for file in files(store)) == 12


def test_a_removed_or_changed_stage_is_seen(store, stage):
    gone, changed, kept = make(store, stage, range(3))
    index.load(store.paths)
    shutil.rmtree(store.paths.folder("fits", gone))
    file = store.paths.folder("fits", changed) / "run.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"name": "another"}))
    for _ in range(2):
        assert {entry.id: entry.name for entry in index.load(store.paths).entries} == {
            changed: "another",
            kept: "toy fit",
        }
    shutil.rmtree(store.paths.folder("fits", kept))
    assert ids(store) == [changed]
    (file,) = files(store)
    assert list(pd.read_parquet(file)["id"]) == [changed]


@pytest.mark.parametrize("damage", [b"", b"PAR1 no table PAR1", None])
def test_a_damaged_file_is_made_again(store, stage, damage):
    make(store, stage, range(2))
    whole = index.load(store.paths)
    (file,) = files(store)
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2] if damage is None else damage)
    assert index.load(store.paths) == whole
    assert not file.exists()
    assert index.load(store.paths) == whole


def test_a_table_of_other_columns_is_made_again(store, stage):
    make(store, stage, range(2))
    whole = index.load(store.paths)
    (file,) = files(store)
    pd.DataFrame({"id": ["x"], "code": ["y"]}).to_parquet(file)
    assert index.load(store.paths) == whole


WATCH = """
    from repro.tracking import index
    from repro.tracking.paths import Paths, outputs_root
    while len(index.load(Paths(outputs_root())).entries) < 20:
        pass
    print(*(entry.id for entry in index.load(Paths(outputs_root())).entries))
"""


def test_several_processes_keep_one_index(store, stage, start):
    watchers = [start(WATCH) for _ in range(2)]
    made = sorted(id for number in range(20) for id in make(store, stage, [number]))
    for watcher in watchers:
        assert watcher.communicate(timeout=60)[0].split() == made
    assert ids(store) == made


def test_an_index_that_cannot_be_written_costs_time_alone(store, stage):
    make(store, stage, range(2))
    store.paths.index.parent.mkdir(exist_ok=True)
    store.paths.index.write_text("no folder")
    assert len(ids(store)) == 2
    assert store.paths.index.is_file()
