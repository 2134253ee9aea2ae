"""The design as a test: which room may import which, and that every choice has its file and its setting."""

import ast
import importlib
import runpy
from collections import Counter
from pathlib import Path

import pytest

from repro.config.registry import groups, settings

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "repro"
LONGEST = 300  # lines
FILES = sorted(SOURCE.rglob("*.py"))
DRAWING = runpy.run_path(str(ROOT / "docs" / "architecture.py"))  # reads the imports
CHOSEN_BY_KIND = ("objectives", "sequences", "metrics", "controllers")
# Files of one name in these folders hold different things that the folder tells apart: a command, a figure, a choice.
NAMED_BY_THEIR_FOLDER = ("commands", "figures", "tables", "bases", "systems", "kinds", "optimisers", *CHOSEN_BY_KIND)
REPEATED = ("Options",)  # of a plugin, one class in each of its files

SCIENCE = ("codegen", "plugins", "mechanics", "models", "data", "learning", "control", "evaluation")
STORED = ("tracking", "results", "claims")
# Rooms from the ground up; each may import itself, `errors`, and what stands here.
MAY_IMPORT: dict[str, tuple[str, ...]] = {
    "errors": (),
    "plugins": (),
    "codegen": (),
    "tracking": ("plugins",),
    "mechanics": ("codegen", "plugins"),
    "models": ("codegen", "plugins", "mechanics"),
    "data": ("codegen", "plugins", "mechanics"),
    "recording": ("tracking",),
    "launch": ("tracking",),
    "results": ("tracking",),
    "learning": ("codegen", "plugins", "mechanics", "models", "data"),
    "control": ("codegen", "plugins", "mechanics", "models", "data"),
    "evaluation": ("codegen", "plugins", "mechanics", "models", "data"),
    "export": ("codegen", "mechanics", "models", "tracking"),
    "claims": ("plugins", "tracking", "results"),
    "config": (*SCIENCE, "tracking"),
    "bench": (*SCIENCE, "tracking"),
    "report": (*STORED, "launch", "recording"),
    "library": (*SCIENCE, "export", "recording", "tracking"),
    "pipeline": (*SCIENCE, *STORED, "recording", "config", "library"),
    "sweep": (*SCIENCE, *STORED, "recording", "launch", "config", "library", "pipeline"),
    "commands": (
        *SCIENCE,
        *STORED,
        "recording",
        "launch",
        "export",
        "config",
        "bench",
        "report",
        "library",
        "pipeline",
        "sweep",
    ),
    "__main__": ("commands", "plugins"),
    "__init__": ("tracking", "recording", "library", "pipeline"),
}


def _modules(folder: str) -> set[str]:
    return {path.stem for path in (SOURCE / folder).glob("*.py") if path.stem != "__init__"}


def _choices(group: str, key: str) -> set[str]:
    """What the files of a group of settings name."""
    return {settings(group, option)[key] for option in groups()[group]}


def test_imports_point_downwards():
    offenders = []
    for path in FILES:
        room = DRAWING["room_of"](path)
        allowed = {room, "errors", *MAY_IMPORT.get(room, ())}
        rooms = {name.split(".")[0] for name in DRAWING["imported"](path)}
        offenders += [f"{path.relative_to(SOURCE)} imports {other}" for other in sorted(rooms - allowed)]
    assert not offenders, "\n".join(offenders)


def test_the_table_has_no_circle():
    """Each room imports only rooms above its own line of the table."""
    order = list(MAY_IMPORT)
    assert all(order.index(other) < order.index(room) for room, allowed in MAY_IMPORT.items() for other in allowed)


def test_every_room_is_in_the_table():
    assert {DRAWING["room_of"](path) for path in FILES} == set(MAY_IMPORT)


def test_there_are_few_rooms_on_few_floors():
    rooms, floors = DRAWING["drawn"]()  # raises for a circle of imports
    assert len(rooms) <= 24
    assert max(floors.values()) <= 9


def test_the_picture_of_the_rooms_is_current(capsys):
    assert DRAWING["main"](["--check"]) == 0, capsys.readouterr().out


def test_the_report_is_a_small_part():
    lines = Counter()
    for path in FILES:
        lines[DRAWING["room_of"](path)] += len(path.read_text().splitlines())
    assert lines["report"] <= 0.18 * lines.total()


def test_imports_are_absolute():
    imports = ((path, node) for path in FILES for node in ast.walk(DRAWING["parsed"](path)))
    relative = [path for path, node in imports if isinstance(node, ast.ImportFrom) and node.level]
    assert not relative


def test_one_name_means_one_thing():
    """No two files and no two classes have the same name."""
    files = Counter(path.stem for path in FILES if path.parent.name not in NAMED_BY_THEIR_FOLDER)
    del files["__init__"]
    nodes = (node for path in FILES for node in ast.walk(DRAWING["parsed"](path)))
    classes = Counter(node.name for node in nodes if isinstance(node, ast.ClassDef))
    repeated = {name for name, count in (*files.items(), *classes.items()) if count > 1}
    assert repeated <= {*REPEATED}


def test_the_hall_holds_three_files():
    assert {path.name for path in SOURCE.glob("*.py")} == {"__init__.py", "__main__.py", "errors.py"}


def test_files_are_short():
    lengths = {str(path.relative_to(SOURCE)): len(path.read_text().splitlines()) for path in FILES}
    assert not {name: length for name, length in lengths.items() if length > LONGEST}


@pytest.mark.parametrize("name", sorted(_modules("models/bases")))
def test_a_basis_is_a_flag_and_two_functions(name):
    basis = importlib.import_module(f"repro.models.bases.{name}")
    assert isinstance(basis.LINEAR, bool)
    assert callable(basis.kinetic) and callable(basis.potential)


@pytest.mark.parametrize(
    ("group", "key", "folder"),
    [
        ("model", "kind", "models/kinds"),
        ("basis", "name", "models/bases"),
        ("system", "name", "mechanics/systems"),
        ("optimiser", "kind", "learning/optimisers"),
        ("control", "kind", "control/controllers"),
        ("objective", "kind", "learning/objectives"),
        ("sequence", "kind", "learning/sequences"),
        ("metric", "kind", "evaluation/metrics"),
    ],
    ids=["model", "basis", "system", "optimiser", "control", "objective", "sequence", "metric"],
)
def test_every_file_is_a_choice_and_every_choice_a_file(group, key, folder):
    assert _choices(group, key) == _modules(folder)


@pytest.mark.parametrize(
    "group", ["model", "basis", "system", "optimiser", "control", "task", "objective", "sequence", "metric"]
)
def test_a_setting_is_named_after_its_file(group):
    """`basis=t1` chooses conf/basis/t1.yaml, which names t1; an optimiser may have several settings."""
    for option in groups()[group]:
        stored = settings(group, option)
        assert stored.get("name", stored.get("kind")) == option
