"""A result says where it comes from, exactly enough to go back there."""

from __future__ import annotations

import subprocess

import pytest

from repro.tracking import provenance
from repro.tracking.stage import Stage


def run(folder, *arguments):
    return subprocess.run(
        ["git", "-c", "user.name=A", "-c", "user.email=a@b.c", *arguments],
        cwd=folder, check=True, capture_output=True, text=True, errors="replace",
    ).stdout  # fmt: skip


@pytest.fixture
def tree(tmp_path, monkeypatch):
    folder = tmp_path / "tree"
    folder.mkdir()
    run(folder, "init", "--quiet", "--initial-branch=main")
    (folder / "model.py").write_text("a = 1\n")
    (folder / "constraints.txt").write_text("numpy==2\n")
    (folder / ".gitignore").write_text("ignored/\n")
    run(folder, "add", ".")
    run(folder, "commit", "--quiet", "-m", "first")
    monkeypatch.setattr(provenance, "source_tree", lambda: folder)
    provenance._source.cache_clear()
    yield folder
    provenance._source.cache_clear()


def test_a_clean_tree_is_its_commit(tree, tmp_path):
    state = provenance.source_state(tmp_path / "outputs" / "patches")
    assert state["commit"] == run(tree, "rev-parse", "HEAD").strip()
    assert state["branch"] == "main"
    assert state["clean"]
    assert state["patch"] is None


def test_commit_and_patch_give_the_tree_back(tree, tmp_path):
    (tree / "model.py").write_bytes(b"a = 2\r\nb = '\xe9'\r\n")
    (tree / "src" / "repro").mkdir(parents=True)
    (tree / "src" / "repro" / "new file.py").write_text("b = 3\n")
    (tree / "ignored").mkdir()
    (tree / "ignored" / "x").write_text("x")
    index = (tree / ".git" / "index").read_bytes()
    state = provenance.source_state(tmp_path / "outputs" / "patches")
    assert (tree / ".git" / "index").read_bytes() == index
    assert not state["clean"]
    assert state["untracked"] == ["src/repro/new file.py"]
    assert state["untracked_not_stored"] == []
    copy = tmp_path / "copy"
    run(tmp_path, "clone", "--quiet", str(tree), str(copy))
    run(copy, "checkout", "--quiet", state["commit"])
    run(copy, "apply", str(tmp_path / "outputs" / state["patch"]))
    for name in ("model.py", "src/repro/new file.py"):
        assert (copy / name).read_bytes() == (tree / name).read_bytes()
    assert provenance.source_state(tmp_path / "outputs" / "patches") == state
    assert len(list((tmp_path / "outputs" / "patches").iterdir())) == 1


@pytest.mark.parametrize(
    "name", [".env", "my.csv", "notes.py", "src/repro/.env", "conf/key.pem", "src/my.py", "a/conf/b.yaml"]
)
def test_what_no_run_is_made_from_stays_private(tree, tmp_path, name):
    (tree / name).parent.mkdir(parents=True, exist_ok=True)
    (tree / name).write_text("password of nobody else")
    state = provenance.source_state(tmp_path / "patches")
    assert state["untracked_not_stored"] == [name]
    stored = b"".join(path.read_bytes() for path in (tmp_path / "patches").iterdir())
    assert b"password" not in stored and name.encode() not in stored


def test_a_tree_without_a_commit_says_so(tmp_path, monkeypatch):
    run(tmp_path, "init", "--quiet")
    (tmp_path / "a.py").write_text("a = 1")
    run(tmp_path, "add", ".")
    monkeypatch.setattr(provenance, "source_tree", lambda: tmp_path)
    state = provenance.source_state(tmp_path / "outputs" / "patches")
    assert state["commit"] is None
    assert "git diff failed" in state["why"]


def test_results_inside_the_tree_are_no_source(tree):
    patches = tree / "outputs" / "patches"
    (tree / "outputs").mkdir()
    (tree / "outputs" / "result.txt").write_text("x")
    assert provenance.source_state(patches)["clean"]


def test_description(tree, tmp_path):
    import numpy  # noqa: F401

    config = {"data": {"seeds": [0, 1], "samples": 5}, "fit": {"seed": 3}}
    stage = Stage("fits", "toy", config, {"data": "d-1"}, (), "repro run")
    origin = provenance.describe(stage, ["a=1"], tmp_path / "outputs" / "patches", provenance.Meter())
    assert origin.seeds == {"data.seeds": [0, 1], "fit.seed": 3}
    assert (origin.command, origin.overrides, origin.upstream) == ("repro run", ("a=1",), {"data": "d-1"})
    assert len(origin.git["constraints_sha256"]) == 64
    assert origin.machine["python"].startswith("3.")
    assert origin.machine["cores_allowed"] >= 1
    assert any(pool["user_api"] == "blas" for pool in origin.threads["pools"])


def test_torch_is_described_when_it_is_loaded(monkeypatch):
    import sys

    monkeypatch.delitem(sys.modules, "torch", raising=False)
    assert provenance._torch() is None
