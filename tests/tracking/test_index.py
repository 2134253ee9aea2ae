"""The index is what the store holds, whatever happens to its files."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing

import pytest

from repro.tracking import cache, index


def query(store, statement):
    with closing(sqlite3.connect(store.paths.index)) as database, database:
        return database.execute(statement).fetchall()


def rows(store):
    names = query(store, "SELECT name FROM entries WHERE name LIKE '%/%'")
    return sorted(place.rpartition("/")[2] for (place,) in names)


def make(store, stage, numbers):
    return [
        store.compute(stage(a=number), lambda folder, number=number: {"card": {"z": number, "a": [1]}}).id
        for number in numbers
    ]


def ids(store):
    return [entry.id for entry in index.load(store.paths).entries]


def test_what_is_new_is_added_and_nothing_else_is_read_or_written(store, stage, monkeypatch):
    first = make(store, stage, range(3))
    fresh = index.load(store.paths)
    assert sorted(first) == [entry.id for entry in fresh.entries] == rows(store)
    content = store.paths.index.read_bytes()
    assert index.load(store.paths) == fresh
    assert store.paths.index.read_bytes() == content
    second = make(store, stage, [3])
    read = []
    entry = index._entry
    monkeypatch.setattr(index, "_entry", lambda content, id, *rest: read.append(id) or entry(content, id, *rest))
    assert ids(store) == sorted(first + second) == rows(store)
    assert ids(store) == sorted(first + second)
    assert read == second
    assert list(index.load(store.paths).finished()[second[0]].card.items()) == [("z", 3), ("a", [1])]


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
    assert rows(store) == [changed]


@pytest.mark.parametrize("damage", [b"", b"\0 no index", b"[]", None])
def test_a_damaged_file_is_made_again(store, stage, damage):
    make(store, stage, range(40))
    whole = index.load(store.paths)
    content = store.paths.index.read_bytes()
    store.paths.index.write_bytes(content[: len(content) // 2] if damage is None else damage)
    assert index.load(store.paths) == whole
    assert index.load(store.paths) == whole
    assert len(rows(store)) == 40


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE entries SET value = 7 WHERE name = 'version'",
        "DELETE FROM entries WHERE name = 'version'",
        "DELETE FROM entries WHERE name LIKE 'code %'",
        "DROP TABLE entries",
        "UPDATE entries SET value = '[1]' WHERE name LIKE '%/%'",
        "UPDATE entries SET value = '{'",
    ],
)
def test_an_index_of_another_format_or_without_a_code_identity_is_made_again(store, stage, statement):
    made = make(store, stage, range(2))
    whole = index.load(store.paths)
    query(store, statement)
    assert index.load(store.paths) == whole
    assert rows(store) == sorted(made)
    stored = dict(query(store, "SELECT name, value FROM entries WHERE name LIKE 'code %'"))
    assert {name.removeprefix("code "): json.loads(code) for name, code in stored.items()} == whole.codes


def test_an_index_that_another_process_keeps_locked_costs_time_alone(store, stage, monkeypatch):
    monkeypatch.setattr(cache, "_LONGEST_WAIT_S", 0.01)
    make(store, stage, range(2))
    index.load(store.paths)
    make(store, stage, range(2, 4))
    with closing(sqlite3.connect(store.paths.index, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        assert len(ids(store)) == 4
        other.execute("ROLLBACK")
    assert len(ids(store)) == 4 and len(rows(store)) == 4


KILLED = """
    import os, signal, sqlite3
    from repro.tracking.paths import Paths, outputs_root
    database = sqlite3.connect(Paths(outputs_root()).index)
    database.execute("PRAGMA cache_size = 1")  # so that pages are written before the end of the transaction
    database.execute("UPDATE entries SET value = value || ' '")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_kill_in_the_middle_of_a_write_costs_time_alone(store, stage, start):
    make(store, stage, range(40))
    whole = index.load(store.paths)
    start(KILLED).communicate(timeout=60)
    journal = store.paths.index.with_name("index.sqlite-journal")
    assert journal.exists()
    for _ in range(2):
        assert index.load(store.paths) == whole
    assert len(rows(store)) == 40


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


def test_an_index_that_cannot_be_opened_costs_time_alone(store, stage):
    make(store, stage, range(2))
    store.paths.index.mkdir(parents=True)
    assert len(ids(store)) == 2
    assert store.paths.index.is_dir()


def test_read_only_results_have_an_index(store, stage):
    made = sorted(make(store, stage, range(2)))
    index.load(store.paths)
    store.paths.index.chmod(0o444)
    store.paths.index.parent.chmod(0o555)
    try:
        assert ids(store) == made
        made = sorted(made + make(store, stage, [2]))
        assert ids(store) == made
    finally:
        store.paths.index.parent.chmod(0o755)
