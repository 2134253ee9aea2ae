"""A stage changes its id when, and only when, something that can matter to its result changes."""

from __future__ import annotations

import importlib
import os
import time

import numpy as np
import pytest

from repro.errors import UserError
from repro.tracking import code
from repro.tracking.cache import Cache
from repro.tracking.stage import Stage

ALL = {"data", "fit", "score", "figure"}


@pytest.mark.parametrize(
    ("file", "old", "new", "dependents"),
    [
        ("report/figure.py", "# how it looks", "# how it looks now", set()),
        ("report/figure.py", "return 1", "return 2", {"figure"}),
        ("learning/loss.py", "error**2", "abs(error)", {"fit", "score", "figure"}),
        ("learning/loss.py", "def loss(error):", 'def loss(error):\n    """Square."""', set()),
        ("learning/loss.py", "error**2", "(error   **   2)  # squared", set()),
        ("learning/kernel.c", "return 1", "return 2", {"fit", "score", "figure"}),
        ("data/make.py", "samples=100", "samples=101", ALL),
        ("data/make.py", "'''Data.", "'''The data.", set()),
        ("errors.py", "pass", "code = 2", set()),
        ("tracking/load.py", "import pandas", "import numpy", set()),
        ("__init__.py", "Lazy", "Other", set()),
    ],
)
def test_an_edit_changes_exactly_the_dependents(root, toy, file, old, new, dependents):
    before = toy.ids()
    toy.edit(file, old, new)
    after = toy.ids()
    assert {role for role in ALL if before[role] != after[role]} == dependents


def test_a_changed_default_changes_exactly_the_dependents(root, toy):
    before = toy.ids()
    assert toy.ids() == before
    assert {role for role, id in toy.ids(epochs=11).items() if id != before[role]} == {"fit", "score", "figure"}
    assert {role for role, id in toy.ids(samples=99).items() if id != before[role]} == ALL


def test_libraries_count_where_they_are_imported(root, toy, monkeypatch):
    before = toy.ids()
    monkeypatch.setattr(code, "version", lambda name: "999" if name == "yaml" else "1")
    code.closure.cache_clear()
    stages = toy.stages()
    assert stages["data"].identity.libraries == {"numpy": "1"}
    assert stages["fit"].identity.libraries == {"numpy": "1", "yaml": "999"}
    assert stages["data"].id != before["data"]


def test_versions_leave_the_build_out():
    assert "+" not in code.version("torch")
    assert code.version("yaml") == code.version("PyYAML")
    assert code.version("no_such_library") == "absent"


def test_modules_reached(root, toy):
    reached = {name.removeprefix(toy.name + ".") for name in toy.stages()["fit"].identity.code}
    assert reached == {"data", "data.make", "learning", "learning.fit", "learning.loss"}


def test_the_same_numbers_written_otherwise_are_the_same(root, toy):
    def id(config):
        return Stage("fits", "SIP  Lagrangian/T2", config, {}, (f"{toy.name}.learning.loss",)).id

    first = id({"a": [0, 1], "b": 0.5})
    assert first == id({"b": np.float64(0.5), "a": (0, np.int64(1))})
    assert first != id({"a": [0, 1], "b": 0.25})
    assert first.startswith("sip-lagrangian-t2-")
    assert len(first.rpartition("-")[2]) == 10


def test_unknown_module_and_syntax_error_name_the_place(root, toy):
    with pytest.raises(UserError, match=r"no module toy.*\.nowhere"):
        _ = Stage("fits", "toy", {}, {}, (f"{toy.name}.nowhere",)).id
    toy.write("data/make.py", "def broken(:\n")
    with pytest.raises(UserError, match=r"make\.py, line 1"):
        toy.ids()


def test_a_file_edited_after_it_was_loaded_is_not_trusted(root, toy, monkeypatch):
    time.sleep(0.02)
    monkeypatch.setattr(code.READER, "started", time.time())
    importlib.import_module(f"{toy.name}.learning.loss")
    toy.ids()
    time.sleep(0.02)
    toy.edit("learning/loss.py", "**2", "**4")
    with pytest.raises(UserError, match=r"loss\.py was edited while this command was running"):
        toy.ids()


def test_code_edited_before_it_is_loaded_by_the_work_is_not_kept(store, toy):
    fit = toy.stages()["fit"]

    def work(folder):
        toy.edit("learning/loss.py", "**2", "**4")
        importlib.import_module(f"{toy.name}.learning.loss")
        return {}

    with pytest.raises(UserError, match=r"loss\.py was edited while this command was running"):
        store.compute(fit, work)
    assert store.find(fit.id) is None


def test_code_edited_after_it_was_loaded_does_not_matter(store, toy, monkeypatch):
    monkeypatch.setattr(code.READER, "started", time.time())
    importlib.import_module(f"{toy.name}.learning.loss")
    fit = toy.stages()["fit"]

    def work(folder):
        toy.edit("learning/loss.py", "**2", "**4")
        return {}

    assert store.compute(fit, work).outcome == "ok"


def test_the_cache_of_digests_only_saves_time(root, toy, monkeypatch):
    ids = toy.ids()
    code.READER.cache.file.write_text("{ damaged")
    monkeypatch.setattr(code.READER, "cache", Cache(code.READER.cache.file, 0))
    code.closure.cache_clear()
    assert toy.ids() == ids


def test_a_hundred_modules_are_read_from_the_cache(root, toy, monkeypatch):
    for path in toy.folder.rglob("*.*"):
        os.utime(path, (time.time() - 60, time.time() - 60))
    ids = toy.ids()
    assert str(toy.folder).encode() in code.READER.cache.file.read_bytes()
    monkeypatch.setattr(code.READER, "cache", Cache(code.READER.cache.file, 0))
    code.closure.cache_clear()
    monkeypatch.setattr(code, "analyse", lambda path, module: pytest.fail(f"{path} was analysed again"))
    assert toy.ids() == ids


def test_a_forked_process_finds_what_others_have_read_since(tmp_path, monkeypatch):
    file, database = tmp_path / "toymodule.py", tmp_path / "code.sqlite"
    file.write_text("import numpy\n")
    os.utime(file, (0, 0))
    forked, other = (code.SourceReader(Cache(database, code._FORMAT)) for _ in range(2))
    assert not forked.cache.values
    source = other.read(file, "toymodule")
    other.save()
    monkeypatch.setattr(code, "analyse", lambda path, module: pytest.fail(f"{path} was analysed again"))
    forked.forked = True
    assert forked.read(file, "toymodule") == source
