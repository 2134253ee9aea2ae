"""The design as a test: which room may import which, and that every choice has its file and its setting."""

import ast
import importlib
import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "repro"
CONF = ROOT / "conf"
LONGEST = 300  # lines
FILES = sorted(SOURCE.rglob("*.py"))

SCIENCE = ("codegen", "plugins", "mechanics", "models", "data", "learning", "control", "evaluation")
STORED = ("tracking", "results", "claims")
# Rooms from the ground up; each may import itself, `errors`, and what stands here.
MAY_IMPORT: dict[str, tuple[str, ...]] = {
    "errors": (),
    "plugins": (),
    "codegen": (),
    "tracking": (),
    "mechanics": ("codegen", "plugins"),
    "models": ("codegen", "plugins", "mechanics"),
    "data": ("codegen", "plugins", "mechanics"),
    "recording": ("tracking",),
    "launch": ("tracking",),
    "results": ("tracking",),
    "learning": ("codegen", "plugins", "mechanics", "models", "data"),
    "control": ("codegen", "plugins", "mechanics", "models", "data"),
    "evaluation": ("codegen", "mechanics", "models", "data"),
    "export": ("codegen", "mechanics", "models", "tracking"),
    "claims": ("tracking", "results"),
    "config": (*SCIENCE, "tracking"),
    "bench": (*SCIENCE, "tracking"),
    "report": (*STORED, "launch", "recording"),
    "pipeline": (*SCIENCE, *STORED, "recording", "config"),
    "sweep": (*SCIENCE, *STORED, "recording", "launch", "config", "pipeline"),
    "commands": (*SCIENCE, *STORED, "recording", "launch", "export", "config", "bench", "report", "pipeline", "sweep"),
    "cli": ("commands",),
    "__init__": ("tracking", "pipeline"),
}


def _imported(path: Path) -> set[str]:
    """Dotted names below `repro` that a file imports anywhere, in functions and by name (a string) too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: imports are absolute"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names |= set(re.findall(r"^repro\.[a-z_]+(?:\.[a-z_]+)*", node.value))
    below = {name.removeprefix("repro.") for name in names if name.startswith("repro.")}
    return {name for name in below if name.split(".")[0] in MAY_IMPORT}


def _room(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def _modules(folder: str) -> set[str]:
    return {path.stem for path in (SOURCE / folder).glob("*.py") if path.stem != "__init__"}


def _choices(group: str, key: str) -> set[str]:
    """What the files of a group of settings name."""
    return {yaml.safe_load(path.read_text())[key] for path in (CONF / group).glob("*.yaml")}


def test_imports_point_downwards():
    offenders = []
    for path in FILES:
        room = _room(path)
        allowed = {room, "errors", *MAY_IMPORT.get(room, ())}
        rooms = {name.split(".")[0] for name in _imported(path)}
        offenders += [f"{path.relative_to(SOURCE)} imports {other}" for other in sorted(rooms - allowed)]
    assert not offenders, "\n".join(offenders)


def test_the_table_has_no_circle():
    """Each room imports only rooms above its own line of the table."""
    order = list(MAY_IMPORT)
    assert all(order.index(other) < order.index(room) for room, allowed in MAY_IMPORT.items() for other in allowed)


def test_every_room_is_in_the_table():
    assert {_room(path) for path in FILES} == set(MAY_IMPORT)


def test_the_hall_holds_three_files():
    assert {path.name for path in SOURCE.glob("*.py")} == {"__init__.py", "cli.py", "errors.py"}


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
    ],
    ids=["model", "basis", "system", "optimiser"],
)
def test_every_file_is_a_choice_and_every_choice_a_file(group, key, folder):
    assert _choices(group, key) == _modules(folder)


@pytest.mark.parametrize("group", ["model", "basis", "system", "optimiser"])
def test_a_setting_is_named_after_its_file(group):
    """`basis=t1` chooses conf/basis/t1.yaml, which names t1; an optimiser may have several settings."""
    for path in (CONF / group).glob("*.yaml"):
        stored = yaml.safe_load(path.read_text())
        assert stored.get("name", stored.get("kind")) == path.stem
