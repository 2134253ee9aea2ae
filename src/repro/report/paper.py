"""What a report knows of the paper that it replicates: paper/report.yaml, and the figures in paper/draw."""

import importlib.util
from collections.abc import Mapping
from dataclasses import field
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as checked

from repro.errors import UserError
from repro.report.animation import Animation
from repro.report.figures.figure import Figure
from repro.report.figures.timing import TIMING
from repro.report.tables.closed_loops import LoopTable
from repro.report.tables.front import FrontTable
from repro.report.tables.identifiability import IdentifiabilityTable
from repro.report.tables.models import ModelTable
from repro.report.tables.paired import PairedTable
from repro.tracking.files import read_yaml
from repro.tracking.paths import project_folder

FILE = "report.yaml"
Query = Annotated[ModelTable | PairedTable | IdentifiabilityTable | LoopTable, Field(discriminator="kind")]


@checked(frozen=True)
class Paper:
    """The contents of report.yaml.

    `systems` are names in the titles of runs, `headlines` claims, `front_figures` figures before the sections.
    """

    title: str
    subtitle: str
    page_title: str
    source: str
    systems: Mapping[str, str] = field(default_factory=dict)
    tables: tuple[Query, ...] = ()
    headlines: tuple[str, ...] = ()
    front_figures: tuple[str, ...] = ()
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
        message = f"{path}, {'.'.join(str(part) for part in first['loc'])}: {first['msg']}"
        raise UserError(message) from error


@cache
def load_figures(folder: Path) -> tuple[Figure, ...]:
    """Return the figures of every file in draw/, in the order of the file names, and those of any paper.

    Raises UserError for a file that defines no FIGURES, or a name that two figures have.
    """
    figures = [figure for path in _drawings(folder) for figure in _figures_of(path)]
    figures.append(TIMING)
    names = [figure.name for figure in figures]
    if repeated := {name for name in names if names.count(name) > 1}:
        message = f"{folder / 'draw'}: several figures are named {', '.join(sorted(repeated))}"
        raise UserError(message)
    return tuple(figures)


@cache
def load_animations(folder: Path) -> tuple[Animation, ...]:
    """Return the animations of every file in draw/ that has ANIMATIONS, in the order of the file names."""
    return tuple(one for path in _drawings(folder) for one in getattr(_module(path), "ANIMATIONS", ()))


def _drawings(folder: Path) -> list[Path]:
    return sorted((folder / "draw").glob("*.py"))


def _figures_of(path: Path) -> tuple[Figure, ...]:
    figures = getattr(_module(path), "FIGURES", None)
    if figures is None:
        message = f"{path} defines no FIGURES, a tuple of repro.report.figures.figure.Figure"
        raise UserError(message)
    return tuple(figures)


@cache
def _module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"{path.parent.name}_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ImportError(str(path))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
