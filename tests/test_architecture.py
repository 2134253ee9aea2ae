"""The design as a test: which way imports point, and that every choice has its file and its setting."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "repro"
CONF = ROOT / "conf"
SCIENCE = ("mechanics", "data", "models", "learning", "evaluation", "control")
LONGEST = 300  # lines
FILES = sorted(SOURCE.rglob("*.py"))


def _imported(path: Path) -> set[str]:
    """Dotted names below `repro` that a file imports anywhere, those in functions too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: imports are absolute"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name.removeprefix("repro.") for name in names if name.startswith("repro.")}


def _rooms(path: Path) -> set[str]:
    """First parts of what a file imports: rooms, and modules beside them."""
    return {name.split(".")[0] for name in _imported(path)}


def _files(*rooms: str) -> list[Path]:
    return [path for path in FILES if path.relative_to(SOURCE).parts[0] in rooms]


def _name(path: Path) -> str:
    return str(path.relative_to(SOURCE))


def _modules(folder: str) -> set[str]:
    return {path.stem for path in (SOURCE / folder).glob("*.py") if path.stem != "__init__"}


def _choices(group: str, key: str) -> set[str]:
    """What the files of a group of settings name."""
    return {yaml.safe_load(path.read_text())[key] for path in (CONF / group).glob("*.yaml")}


@pytest.mark.parametrize("path", _files(*SCIENCE), ids=_name)
def test_science_imports_from_earlier_rooms_only(path):
    room = path.relative_to(SOURCE).parts[0]
    earlier = set(SCIENCE[: SCIENCE.index(room) + 1])
    assert _rooms(path) <= earlier | {"errors"}


@pytest.mark.parametrize("path", _files("tracking"), ids=_name)
def test_tracking_knows_no_physics(path):
    assert _rooms(path) <= {"tracking", "errors"}


@pytest.mark.parametrize("path", _files("report"), ids=_name)
def test_the_report_reads_what_tracking_stored_and_nothing_else(path):
    assert _rooms(path) <= {"report", "tracking", "errors"}


@pytest.mark.parametrize("path", _files("stages"), ids=_name)
def test_stages_take_plain_arguments(path):
    """They join the science with what is recorded, and know neither the schema nor the store."""
    assert _rooms(path) <= {*SCIENCE, "errors", "tracking"}
    tracking = {name for name in _imported(path) if name.startswith("tracking.")}
    assert all(name.startswith(("tracking.recording.", "tracking.chain_recording.")) for name in tracking)


@pytest.mark.parametrize("path", _files("bench"), ids=_name)
def test_the_bench_times_the_science_without_the_schema(path):
    assert _rooms(path) <= {*SCIENCE, "bench", "errors", "tracking"}


@pytest.mark.parametrize("path", _files("export"), ids=_name)
def test_the_export_opens_runs_and_reads_no_schema(path):
    assert _rooms(path) <= {*SCIENCE, "export", "errors", "opened", "tracking"}


def test_rooms_are_all_known():
    """A room that is not named here escapes every rule above."""
    rooms = {path.parent.name for path in SOURCE.glob("*/__init__.py")}
    assert rooms <= {*SCIENCE, "tracking", "report", "stages", "bench", "export"}


@pytest.mark.parametrize("path", FILES, ids=_name)
def test_files_are_short(path):
    assert len(path.read_text().splitlines()) <= LONGEST


@pytest.mark.parametrize("name", sorted(_modules("models/bases")))
def test_a_basis_is_a_flag_and_two_functions(name):
    basis = importlib.import_module(f"repro.models.bases.{name}")
    assert isinstance(basis.LINEAR, bool)
    assert callable(basis.kinetic) and callable(basis.potential)


def _buildable() -> set[str]:
    return {name for name in _modules("models") if hasattr(importlib.import_module(f"repro.models.{name}"), "build")}


def _optimisers() -> set[str]:
    from repro.learning.optimiser import Optimiser

    found = set()
    for name in _modules("learning"):
        module = importlib.import_module(f"repro.learning.{name}")
        members = [m for m in vars(module).values() if isinstance(m, type) and m.__module__ == module.__name__]
        found |= {name for m in members if issubclass(m, Optimiser) and not inspect.isabstract(m)}
    return found


@pytest.mark.parametrize(
    ("group", "key", "files"),
    [
        ("model", "kind", _buildable),
        ("basis", "name", lambda: _modules("models/bases")),
        ("system", "name", lambda: _modules("mechanics/systems")),
        ("optimiser", "kind", _optimisers),
    ],
    ids=["model", "basis", "system", "optimiser"],
)
def test_every_file_is_a_choice_and_every_choice_a_file(group, key, files):
    assert _choices(group, key) == files()


@pytest.mark.parametrize("group", ["model", "basis", "system", "optimiser"])
def test_a_setting_is_named_after_its_file(group):
    """`basis=t1` chooses conf/basis/t1.yaml, which names t1; an optimiser may have several settings."""
    for path in (CONF / group).glob("*.yaml"):
        stored = yaml.safe_load(path.read_text())
        assert stored.get("name", stored.get("kind")) == path.stem
