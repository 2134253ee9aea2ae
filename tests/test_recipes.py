"""The recipes of docs/extending.md, exactly as written, in a copy of the project."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest
import yaml

from repro.tracking.load import load_runs

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "extending.md"
COPIED = ("src", "conf", "experiments", "paper", "pyproject.toml", ".gitignore")
FENCE = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
AT_THE_END = " (at the end)"
QUICK = ("A system",)


@dataclass(frozen=True)
class Recipe:
    """One section of the page: the files that it writes (path -> text, at the end where so marked), its commands."""

    name: str
    files: dict[str, str]
    commands: list[list[str]]

    @property
    def paths(self) -> set[str]:
        return {path.removesuffix(AT_THE_END) for path in self.files}

    def write(self, root: Path) -> None:
        for titled, text in self.files.items():
            path = root / titled.removesuffix(AT_THE_END)
            before = path.read_text() if titled.endswith(AT_THE_END) else ""
            assert titled.endswith(AT_THE_END) or not path.exists(), f"{path} is there already"
            path.write_text(before + text)


def recipes() -> Iterator[Recipe]:
    for section in re.split(r"^## ", PAGE.read_text(), flags=re.MULTILINE)[1:]:
        blocks = FENCE.findall(section)
        lines = [line for language, _, text in blocks if language == "sh" for line in text.splitlines()]
        files = {title: text for _, title, text in blocks if title}
        yield Recipe(section.partition("\n")[0], files, [shlex.split(line) for line in lines])


RECIPES = {recipe.name: recipe for recipe in recipes()}


@dataclass(frozen=True)
class Project:
    """A copy of the project under git, and the store that its commands write to."""

    root: Path
    outputs: Path

    def do(self, command: list[str]) -> str:
        assert command[0] == ".venv/bin/repro", command
        environment = {**os.environ, "PYTHONPATH": str(self.root / "src"), "REPRO_OUTPUTS": str(self.outputs)}
        program = [sys.executable, "-m", "repro", *command[1:]]
        done = subprocess.run(program, cwd=self.root, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def changed(self) -> set[str]:
        return {line[3:] for line in git(self.root, "status", "--porcelain", "-uall").splitlines()}


def git(root: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
    return subprocess.run(
        ["git", "-C", str(root), *identity, *arguments], check=True, capture_output=True, text=True
    ).stdout


@pytest.fixture
def project(tmp_path: Path) -> Project:
    root = tmp_path / "project"
    for name in COPIED:
        source, target = ROOT / name, root / name
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        else:
            shutil.copyfile(source, target)
    git(root, "init", "-q")
    git(root, "add", ".")
    git(root, "commit", "-qm", "all")
    return Project(root, tmp_path / "outputs")


def metrics(project: Project, **filters: object) -> pd.DataFrame:
    """Metric -> values of the members, on the test split."""
    found = load_runs(root=project.outputs, **filters)
    assert set(found["member"]) == {0, 1}
    return found[found["split"] == "test"].groupby("metric")["value"].max()


def a_system(project: Project, printed: str) -> None:
    worst = metrics(project, system="tethered")
    assert worst["mae_tau"] < 1e-8
    assert "tethered" in printed


def a_mechanism(project: Project, printed: str) -> None:
    learned = load_runs(root=project.outputs, system="crane", model="structured")
    skill = learned[(learned["split"] == "test") & (learned["metric"] == "skill_tau")]["value"]
    assert len(skill) == 2
    assert skill.min() > 0.9
    assert list((project.outputs / "recordings").glob("crane-structured*/recording.rrd"))
    assert list((project.outputs / "recordings").glob("crane-truth*/recording.rrd"))


def a_basis(project: Project, printed: str) -> None:
    assert "rank 6 of 6 terms" in printed
    assert metrics(project, basis="shifted")["mae_tau"] < 1e-8


def a_model(project: Project, printed: str) -> None:
    assert metrics(project, model="fourier")["mae_tau"] < 1e-6
    assert "2 jobs" in printed


def an_optimiser(project: Project, printed: str) -> None:
    assert metrics(project, optimiser="trust_region")["mae_tau"] < 1e-6
    assert "2 jobs" in printed


def an_objective(project: Project, printed: str) -> None:
    assert metrics(project, objective="robust")["mae_tau"] < 1e-6


def a_sequence(project: Project, printed: str) -> None:
    worst = metrics(project, sequence="rehearsal")
    assert worst["mae_tau"] < 1e-8
    assert worst["mae_H_legendre"] < 1e-8


def a_metric(project: Project, printed: str) -> None:
    assert metrics(project, basis="t1")["mirror_tau"] < 1e-10


def a_controller(project: Project, printed: str) -> None:
    loops = pd.concat(pd.read_parquet(path) for path in (project.outputs / "control").glob("*/control.parquet"))
    assert loops["success"].all()


def a_figure(project: Project, printed: str) -> None:
    report = project.outputs / "report" / "smoke"
    assert (report / "figures" / "bases.png").is_file()
    assert "Bases, seed by seed" in (report / "index.html").read_text()


def an_experiment(project: Project, printed: str) -> None:
    table = pd.read_csv(project.outputs / "report" / "smoke" / "tables" / "sip_noise.csv")
    noises = table.loc[table["model"] == "structured", "qdd_noise"]
    assert sorted(noises.astype(float)) == [0.0, 0.1, 1.0]
    assert {"trivial (τ = 0)", "degenerate (L = pₓ²/2m)"} <= set(table["model"])
    assert "sip_noise" in (project.outputs / "report" / "smoke" / "index.html").read_text()
    listed = json.loads((project.outputs / "experiments" / "smoke" / "sip_noise.json").read_text())
    assert len(listed["jobs"]) == 8


def a_claim(project: Project, printed: str) -> None:
    verdicts = pd.read_csv(project.outputs / "report" / "smoke" / "results" / "claims.csv").set_index("id")
    assert verdicts.loc["N1", "leaning"] == "supported"
    assert "N1" in printed


LAGRANGIAN_SETTINGS = "conf/model/lagrangian.yaml"

OUTCOMES: dict[str, Callable[[Project, str], None]] = {
    "A system": a_system,
    "A mechanism of any kind": a_mechanism,
    "A basis": a_basis,
    "A model": a_model,
    "An optimiser": an_optimiser,
    "An objective": an_objective,
    "A sequence": a_sequence,
    "A metric": a_metric,
    "A controller": a_controller,
    "An experiment": an_experiment,
    "A claim": a_claim,
    "A figure": a_figure,
}


def test_every_section_is_a_recipe_that_is_tried() -> None:
    assert list(RECIPES) == list(OUTCOMES)
    assert all(recipe.files and recipe.commands for recipe in RECIPES.values())
    shown = PAGE.read_text().count("\n```") // 2
    assert shown == len(FENCE.findall(PAGE.read_text()))


@pytest.mark.parametrize("name", RECIPES)
def test_the_files_of_a_recipe_are_well_formed(name: str, tmp_path: Path) -> None:
    for number, (path, text) in enumerate(RECIPES[name].files.items()):
        if path.endswith(".py"):
            file = tmp_path / f"recipe_{number}.py"
            file.write_text(text)
            ruff = [sys.executable, "-m", "ruff"]
            for check in (["check"], ["format", "--check"]):
                options = ["--no-cache", "--config", str(ROOT / "pyproject.toml")]
                done = subprocess.run([*ruff, *check, *options, str(file)], capture_output=True, text=True, check=False)
                assert done.returncode == 0, done.stdout
        else:
            assert yaml.safe_load(text)


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in RECIPES]
)
def test_a_recipe_does_what_it_says_and_touches_nothing_else(name: str, project: Project) -> None:
    recipe = RECIPES[name]
    recipe.write(project.root)
    printed = "".join(project.do(command) for command in recipe.commands)
    OUTCOMES[name](project, printed)
    assert project.changed() == recipe.paths


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
def test_a_new_option_of_a_model_is_a_field_of_its_module_and_a_line_of_its_settings(project: Project) -> None:
    """It is checked like any other, is part of the id of a run, and shows in the list of runs."""
    module, settings = (project.root / name for name in ("src/repro/models/kinds/lagrangian.py", LAGRANGIAN_SETTINGS))
    field = '    damping: Damping = "none"\n'
    text = module.read_text()
    assert field in text
    module.write_text(text.replace(field, f"{field}    sharpness: Count = 1\n"))
    settings.write_text(f"{settings.read_text()}sharpness: 1 # has no effect\n")
    chosen = ["basis=t1", "optimiser=least_squares", "scale=smoke", "record=false"]
    for value in ("1", "7"):
        project.do([".venv/bin/repro", "run", f"model.sharpness={value}", *chosen])
    listed = project.do([".venv/bin/repro", "runs"])
    assert listed.count("sharpness=7") == 1 and "sharpness=1" not in listed
    assert load_runs(root=project.outputs)["run"].nunique() == 2
    assert project.changed() == {str(path.relative_to(project.root)) for path in (module, settings)}
