"""Plugins outside of the package: found by name, imported, and part of the code of a stage."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from repro.errors import UserError
from repro.plugins import roots
from repro.plugins.plugin import plugin_names

PROGRAM = """
from repro.plugins.plugin import plugin, plugin_names
from repro.tracking.code import closure
module = plugin("models.bases", "mine")
assert "mine" in plugin_names("models.bases") and "t1" in plugin_names("models.bases")
assert module.LINEAR and "repro.models.bases.mine" in closure(("repro.models.bases.mine",)).code
print(closure(("repro.models.bases.mine",)).code["repro.models.bases.mine"])
"""
BASIS = "LINEAR = True\nSCALE = {scale}\n"


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "my plugins" / "models" / "bases"
    place.mkdir(parents=True)
    (place / "mine.py").write_text(BASIS.format(scale=1.0))
    yield tmp_path / "my plugins"
    roots.plugin_roots.cache_clear()
    plugin_names.cache_clear()


def _digest(folder: Path) -> str:
    environment = {**os.environ, roots.VARIABLE: str(folder)}
    done = subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_a_module_of_a_folder_is_imported_and_its_code_identified(folder):
    before = _digest(folder)
    (folder / "models" / "bases" / "mine.py").write_text(BASIS.format(scale=2.0))
    assert _digest(folder) != before


def test_a_name_that_exists_twice_is_refused(folder, monkeypatch):
    (folder / "models" / "bases" / "t1.py").write_text(BASIS.format(scale=1.0))
    monkeypatch.setenv(roots.VARIABLE, str(folder))
    roots.plugin_roots.cache_clear()
    plugin_names.cache_clear()
    with pytest.raises(UserError, match=r"t1\.py: .*t1\.py has this name too"):
        plugin_names("models.bases")


def test_a_folder_that_does_not_exist_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv(roots.VARIABLE, str(tmp_path / "nowhere"))
    roots.plugin_roots.cache_clear()
    with pytest.raises(UserError, match="nowhere: there is no such folder"):
        roots.plugin_roots()
    roots.plugin_roots.cache_clear()
    with pytest.raises(UserError, match="--plugins"):
        roots.add_root(str(tmp_path / "nowhere"))
