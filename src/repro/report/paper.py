"""What a report knows of the paper that it replicates: paper/report.yaml, and the figures in paper/draw."""

import runpy
from collections.abc import Mapping
from dataclasses import field
from functools import cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as checked

from repro.errors import UserError
from repro.report.animation import Animation
from repro.report.figures.figure import Figure
from repro.report.figures.timing import TIMING
from repro.report.tables.closed_loops import LoopTable
from repro.report.tables.identifiability import IdentifiabilityTable
from repro.report.tables.models import FrontTable, ModelTable
from repro.report.tables.paired import PairedTable
from repro.tracking.files import read_yaml
from repro.tracking.paths import project_folder

FILE = "report.yaml"
Query = Annotated[ModelTable | PairedTable | IdentifiabilityTable | LoopTable, Field(discriminator="kind")]


@checked(frozen=True)
class Paper:
    """The contents of report.yaml."""

    title: str
    subtitle: str
    page_title: str
    source: str
    systems: Mapping[str, str] = field(default_factory=dict)  # names in the titles of runs
    tables: tuple[Query, ...] = ()
    headlines: tuple[str, ...] = ()  # claims
    front_figures: tuple[str, ...] = ()  # before the sections
    front_tables: tuple[FrontTable, ...] = ()


def paper_folder() -> Path:
    """Return the folder of the paper in the checkout. Raises UserError where the package lies outside of one."""
    return project_folder() / "paper"


@cache
def load_paper(folder: Path) -> Paper:
    """Read report.yaml. Raises UserError naming the key and what is wrong with it."""
    path = folder / FILE
    try:
        return TypeAdapter(Paper).validate_python(read_yaml(path))
    except ValidationError as error:
        first = error.errors()[0]
        raise UserError(f"{path}, {'.'.join(str(part) for part in first['loc'])}: {first['msg']}") from error


@cache
def load_figures(folder: Path) -> tuple[Figure, ...]:
    """The figures of draw/ by file name, and those of any paper. UserError without FIGURES, or a name used twice."""
    figures: list[Figure] = []
    for path, content in _drawings(folder).items():
        if "FIGURES" not in content:
            raise UserError(f"{path} defines no FIGURES, a tuple of repro.report.figures.figure.Figure")
        figures += content["FIGURES"]
    figures += TIMING
    names = [figure.name for figure in figures]
    if repeated := {name for name in names if names.count(name) > 1}:
        raise UserError(f"{folder / 'draw'}: several figures are named {', '.join(sorted(repeated))}")
    return tuple(figures)


@cache
def load_animations(folder: Path) -> tuple[Animation, ...]:
    """Return the animations of every file in draw/ that has ANIMATIONS, in the order of the file names."""
    return tuple(one for content in _drawings(folder).values() for one in content.get("ANIMATIONS", ()))


@cache
def _drawings(folder: Path) -> dict[Path, dict[str, Any]]:
    """What each file in draw/ defines, in the order of the file names."""
    paths = sorted((folder / "draw").glob("*.py"))
    return {path: runpy.run_path(str(path), run_name=f"draw_{path.stem}") for path in paths}
