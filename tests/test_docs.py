"""The documentation: its links resolve, its commands are understood, and the site builds without a warning."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import pandas as pd
import pytest
import yaml
from optional import needs_extra

from repro import __main__ as cli
from repro.config.compose import plan
from repro.config.overrides import expand, experiment_of
from repro.launch import cluster

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "paper" / "ARTIFACT.md", *sorted((ROOT / "docs").rglob("*.md"))]
# Their commands are tried in test_recipes.py, and with their recordings in pipeline/test_recording.py.
TRIED_ELSEWHERE = ("extending.md", "real-data.md")
FENCED = re.compile(r"^```[^\n]*\n.*?^```$", re.MULTILINE | re.DOTALL)
SHELL = re.compile(r"^```(?:sh|bash|)\n(.*?)^```$|((?:^    \S.*\n)+)", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"(?<!`)`(repro [^`\n]+)`")


def prose(page: Path) -> str:
    """A page without its code."""
    return re.sub(r"`[^`\n]*`", "", FENCED.sub("", page.read_text()))


def links(page: Path) -> list[str]:
    return re.findall(r"\]\(([^)\s]+)\)", prose(page)) + re.findall(r'(?:src|href)="([^"]+)"', prose(page))


def anchors(page: Path) -> set[str]:
    """The headings as GitHub and MkDocs both name them."""
    headings = re.findall(r"^#+ +(.+?) *$", FENCED.sub("", page.read_text()), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def named(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_relative_link_resolves(page: Path) -> None:
    broken = []
    for link in links(page):
        split = urlsplit(link)
        if split.scheme:
            continue
        target = (page.parent / unquote(split.path)).resolve() if split.path else page
        if not target.exists() or (split.fragment and split.fragment not in anchors(target)):
            broken.append(link)
    assert broken == []


def commands() -> Iterator[tuple[str, list[str]]]:
    """(page, words after `repro`) of every command that a page shows."""
    for page in PAGES:
        if page.name in TRIED_ELSEWHERE:
            continue
        blocks = ["".join(found).replace("\\\n", " ") for found in SHELL.findall(page.read_text())]
        lines = [line.strip() for block in blocks for line in block.splitlines()]
        for line in [*lines, *INLINE.findall(FENCED.sub("", page.read_text()))]:
            program = re.match(r"(?:\.venv/bin/)?repro +(.+)", line)
            if program:
                yield named(page), shlex.split(program[1], comments=True)


SHOWN = {" ".join(words): words for _, words in commands()}


class UnderstoodError(Exception):
    """What argparse made of a command line, before anything is done with it."""


@pytest.fixture
def only_parsed(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("parse_args", "parse_intermixed_args"):
        original = getattr(argparse.ArgumentParser, name)

        def parse(self, *arguments, original=original):
            raise UnderstoodError(original(self, *arguments))

        monkeypatch.setattr(argparse.ArgumentParser, name, parse)
    monkeypatch.setattr(cluster, "_is_installed", lambda plugin: True)  # extras are shown, installed or not


def overrides_of(words: list[str], recording: Path) -> list[tuple[str, ...]]:
    """The jobs that the command line of `run`, `identify` or `reproduce` asks for."""
    given = [word for word in words[1:] if "=" in word and not word.startswith("--")]
    own, _ = cluster.split([word.replace("my.csv", str(recording)) for word in given])
    return expand(own)


@pytest.mark.parametrize("shown", SHOWN)
def test_every_command_is_understood(shown: str, only_parsed: None, tmp_path: Path) -> None:
    words = [word for word in SHOWN[shown] if word not in ("...", "--help")]
    if len(words) == 1:  # named in passing
        assert words[0] in (*cli.COMMANDS, "COMMAND")
        return
    with pytest.raises(UnderstoodError):
        cli.main(words)
    recording = tmp_path / "my.csv"
    rows = [f"{0.1 * k:.1f},{0.005 * k**2},{0.2 * k:.1f},{0.1 * k:.1f},2,1,0" for k in range(20)]
    recording.write_text("\n".join(["time,x,theta,xd,thetad,force,torque", *rows]))
    if words[0] in ("run", "identify", "reproduce"):
        jobs = overrides_of(words, recording)
        assert plan(jobs[:1] if any(map(experiment_of, jobs)) else jobs, tmp_path)


def test_the_budgets_of_the_artefact_hold_for_the_committed_results() -> None:
    text = (ROOT / "paper" / "ARTIFACT.md").read_text()
    minutes, megabytes = (
        float(re.search(rf"^\| {what} \| (\d+) {unit}", text, re.MULTILINE)[1])
        for what, unit in (
            ("processor time of all committed fits", "min"),
            ("committed results", "MB"),
        )
    )
    metrics = pd.read_parquet(ROOT / "paper" / "results" / "metrics.parquet")
    fits = metrics[metrics["metric"] == "fit_seconds"].drop_duplicates(["run", "member"])
    assert fits["value"].sum() < 60 * minutes
    assert sum(path.stat().st_size for path in (ROOT / "paper" / "results").iterdir()) < 1e6 * megabytes


def test_the_citation_names_this_version_and_the_paper() -> None:
    """The keys that the Citation File Format 1.2.0 requires, and what a citation of this project needs."""
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert (citation["version"], citation["license"]) == (project["version"], project["license"])
    (paper,) = citation["references"]
    assert paper["type"] == "conference-paper" and paper["year"] == 2022
    assert [author["family-names"] for author in paper["authors"]] == ["Bao", "Thesma", "Kelkar", "Mohammadpour Velni"]


def test_every_file_of_the_project_that_is_named_exists() -> None:
    missing = []
    for page in PAGES:
        text = page.read_text()
        for name in re.findall(r"^::: (repro[\w.]*)", text, re.MULTILINE):
            path = ROOT / "src" / name.replace(".", "/")
            if (
                not path.is_dir()
                and not path.with_suffix(".py").exists()
                and not path.parent.with_suffix(".py").exists()
            ):
                missing.append(f"{named(page)}: {name}")
        made = re.findall(r'title="([^"]+)"', text)  # by the recipes of the page
        for name in re.findall(r"`([\w./-]+\.(?:py|yaml|toml|css))`", text):
            exists = any((folder / name).exists() for folder in (ROOT, ROOT / "src" / "repro", page.parent))
            if "/" in name and "NAME" not in name and name not in made and not exists:
                missing.append(f"{named(page)}: {name}")
    assert not missing, "\n".join(missing)


# Rooms that are used through commands or other rooms, not imported by users.
PLUMBING = {"bench", "claims", "codegen", "commands", "config", "export", "launch", "pipeline", "plugins", "recording"}
PLUMBING |= {"report", "results", "sweep"}


def test_every_room_is_in_the_reference() -> None:
    rooms = {path.parent.name for path in (ROOT / "src" / "repro").glob("*/__init__.py")}
    pages = {page.stem for folder in ("docs", "docs/reference") for page in (ROOT / folder).glob("*.md")}
    assert rooms - PLUMBING <= pages


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text().splitlines()) <= 120


SIZED = (
    *(
        "scale=",
        "seeds=",
        "record=",
        "data.samples=",
        "optimiser.epochs=",
        "optimiser.iterations=",
        "chain=",
        "whole_chain=",
    ),
    *("sequence.pretraining_epochs=", "task.seconds=", "sequence.initial_angles=", "energies.horizons=", "device="),
)


def examples() -> dict[str, list[str]]:
    """The runs and examinations that the pages show, each cut to a single member and the scale smoke."""
    cut = {}
    for line, words in SHOWN.items():
        if words[0] not in ("run", "identify") or {"--help", "..."} & {*words} or len(words) == 1:
            continue
        if any(word.startswith("hydra/launcher=") for word in words):  # needs an extra
            continue
        own = [word for word in words if not word.startswith(SIZED)]
        cut[line] = [*own, "scale=smoke", "seeds=1", *(["record=false"] if words[0] == "run" else [])]
    return cut


def ended(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """A command line in a folder with a recording of one's own, and results in `outputs`."""
    time = 0.04 * np.arange(100)
    columns = {"x": np.sin(time), "theta": np.cos(2 * time), "xd": np.cos(time), "thetad": -2 * np.sin(2 * time)}
    forces = {"force": np.sin(3 * time), "torque": np.zeros(100), "time": time}
    pd.DataFrame({**columns, **forces}).to_csv(folder / "my.csv")
    environment = {**os.environ, "REPRO_OUTPUTS": str(folder / "outputs")}
    command = [sys.executable, "-m", "repro", *words]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.parametrize("shown", examples())
def test_a_documented_run_runs(shown: str, tmp_path: Path) -> None:
    words = examples()[shown]
    done = ended(words, tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    if words[0] == "run" and "--dry-run" not in words:
        assert list((tmp_path / "outputs" / "runs").glob("*/run.json"))


@pytest.fixture(scope="module")
def two_runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    folder = tmp_path_factory.mktemp("documented")
    done = ended(["run", "-m", "basis=t1", "optimiser=least_squares,lbfgs", "scale=smoke", "seeds=1"], folder)
    assert done.returncode == 0, done.stderr
    return folder, sorted(path.parent.name for path in (folder / "outputs" / "runs").glob("*/run.json"))


# Commands on stored runs, as the pages show them; --open, --web and a window need a display.
ON_RUNS = ["status", "status --why ID", "runs basis=t1", "show ID", "diff ID OTHER", "report", "export ID FOLDER"]
ON_RUNS += ["sensitivity --dry-run", "completion bash", "run -m --failed basis=t1 optimiser=least_squares scale=smoke"]


@pytest.mark.slow
@pytest.mark.parametrize("shown", ON_RUNS)
def test_a_documented_command_on_stored_runs_runs(shown: str, two_runs: tuple[Path, list[str]]) -> None:
    folder, (one, other) = two_runs
    done = ended([{"ID": one, "OTHER": other}.get(word, word) for word in shown.split()], folder)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("block", re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL))
def test_the_python_of_the_readme_runs(block: str, tmp_path: Path) -> None:
    environment = {**os.environ, "REPRO_OUTPUTS": str(tmp_path / "outputs")}
    command = [sys.executable, "-c", block]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.extras
@needs_extra("docs", "mkdocs")
def test_the_site_builds_without_a_warning_and_loads_nothing_from_elsewhere(tmp_path: Path) -> None:
    site = tmp_path / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(site)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = sorted(site.rglob("*.html"))
    assert {"index.html", "control.html", "extending.html", "ARTIFACT.html"} <= {page.name for page in pages}
    loaded = re.compile(
        r"<(?:script|img|iframe)[^>]+src=\"?(https?:)?//|<link[^>]+rel=\"?(?:stylesheet|preconnect)[^>]+//"
    )
    for page in pages:
        assert not loaded.search(page.read_text()), page
    assert "load_run" in (site / "reference" / "index.html").read_text()
