"""The code names nothing of the paper: its experiments, claims and systems stand in experiments/, conf/ and paper/."""

import ast
import re

from repro.tracking.paths import project_folder

ROOT = project_folder()
SOURCE = ROOT / "src" / "repro"
CLEAN = ("report", "results", "claims", "sweep", "pipeline", "commands", "config")
WORDS = {"measured", "link"}  # of plain English, which an experiment and a system are named after
CLAIM = re.compile(r"C\d+[a-z]?")


def names_of_the_paper() -> set[str]:
    """Experiments, but for those whose name is a module too, and systems."""
    modules = {path.stem for path in SOURCE.rglob("*.py")}
    experiments = {path.stem for path in (ROOT / "experiments").glob("*.yaml")} - modules
    systems = {path.stem for path in (ROOT / "conf" / "system").glob("*.yaml")}
    return (experiments | systems) - WORDS


def literals(path) -> list[tuple[int, str]]:
    """Strings of a file with their lines."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [(node.lineno, node.value) for node in nodes if isinstance(node, ast.Constant) and type(node.value) is str]


def offenders(room: str) -> list[str]:
    names = names_of_the_paper()
    return [
        f"{path.relative_to(SOURCE)}:{line} names {text!r}"
        for path in sorted((SOURCE / room).rglob("*.py"))
        for line, text in literals(path)
        if text in names or CLAIM.fullmatch(text)
    ]


def test_no_string_is_a_name_of_the_paper():
    found = [line for room in CLEAN for line in offenders(room)]
    assert not found, "\n".join(found)
