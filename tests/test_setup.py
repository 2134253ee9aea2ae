"""A fresh clone sets itself up: pinned dependencies, one command each, and every file of settings inside it."""

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def canonical(requirement):
    return re.split(r"[<>=!~; \[]", requirement)[0].lower().replace("_", "-")


def test_every_dependency_is_pinned():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = {canonical(text) for text in [*project["dependencies"], *project["optional-dependencies"]["dev"]]}
    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    pinned = {canonical(line): line for line in lines if line.strip()}
    assert wanted <= set(pinned)
    assert all("==" in line for line in pinned.values())


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_make_help_names_every_target():
    text = (ROOT / "Makefile").read_text()
    (phony,) = re.findall(r"^\.PHONY: (.*)$", text, re.MULTILINE)
    shown = subprocess.run(
        ["make", "--no-print-directory", "help"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout
    assert all(f"make {target} " in shown for target in phony.split())
    assert "SCALE=smoke|quick|paper" in shown


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_make_passes_the_scale_on():
    command = ["make", "--no-print-directory", "-n", "-o", ".venv/.installed", "reproduce", "SCALE=paper"]
    shown = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert shown.strip().endswith("repro reproduce scale=paper")
