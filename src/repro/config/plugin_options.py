"""The options of a model or an optimiser: what the file that its `kind` names declares."""

import inspect
import pkgutil
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal, get_type_hints

from pydantic import BaseModel, ValidationError, create_model

from repro.config.base import Section
from repro.config.error_lines import choose, lines
from repro.errors import UserError

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser

COUNTS = ("epochs", "iterations", "batch_size", "samples", "restarts", "curve_points")


def model_options(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Check conf/model against the keywords of `build` in repro/models/<kind>.py; UserError names what is allowed."""
    kind = raw.get("kind")
    if not _builds(str(kind)):
        raise UserError(choose("model.kind", kind, kinds("model")))
    checked = _checked(_model_schema(str(kind)), "model", raw)
    for key, value in checked.items():
        numbers = value if isinstance(value, list) else [value]
        if any(isinstance(n, int) and not isinstance(n, bool) and n < 1 for n in numbers):
            raise UserError(f"model.{key} = {value}: every number must be at least 1")
    return checked


def optimiser_options(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Check conf/optimiser against the fields of the optimiser in repro/learning/<kind>.py; UserError as above."""
    kind = raw.get("kind")
    if _optimiser(str(kind)) is None:
        raise UserError(choose("optimiser.kind", kind, kinds("optimiser")))
    checked = _checked(_optimiser_schema(str(kind)), "optimiser", raw)
    for key, value in checked.items():
        if isinstance(value, int | float) and not isinstance(value, bool) and value < 0:
            raise UserError(f"optimiser.{key} = {value}: must not be negative")
        if key in COUNTS and value == 0:
            raise UserError(f"optimiser.{key} = 0: must be at least 1")
    return checked


def optimiser_class(kind: str) -> type["Optimiser"]:
    """The optimiser that the file repro/learning/<kind>.py holds; UserError for a file that holds none."""
    found = _optimiser(kind)
    if found is None:
        raise UserError(f"repro/learning/{kind}.py holds no optimiser")
    return found


def kinds(group: Literal["model", "optimiser"]) -> list[str]:
    """The files of a group that hold something to choose."""
    if group == "model":
        return [name for name in choices("repro.models") if _builds(name)]
    return [name for name in choices("repro.learning") if _optimiser(name) is not None]


def choices(package: str) -> list[str]:
    """Names of the files of a package, e.g. repro.models.bases."""
    return sorted(module.name for module in pkgutil.iter_modules(import_module(package).__path__))


@cache
def _optimiser(kind: str) -> type["Optimiser"] | None:
    from repro.learning.optimiser import Optimiser

    if kind not in choices("repro.learning"):
        return None
    module = import_module(f"repro.learning.{kind}")
    members = (m for m in vars(module).values() if inspect.isclass(m) and not inspect.isabstract(m))
    own = (m for m in members if issubclass(m, Optimiser) and m.__module__ == module.__name__)
    return next(own, None)


@cache
def _builds(kind: str) -> bool:
    return kind in choices("repro.models") and hasattr(import_module(f"repro.models.{kind}"), "build")


@cache
def _model_schema(kind: str) -> type[BaseModel]:
    build = import_module(f"repro.models.{kind}").build
    hints = get_type_hints(build)
    keywords = [p for p in inspect.signature(build).parameters.values() if p.kind is p.KEYWORD_ONLY]
    options: dict[str, Any] = {p.name: (hints[p.name], ... if p.default is p.empty else p.default) for p in keywords}
    return create_model("model", __base__=Section, **({"kind": (str, ...)} | options))


@cache
def _optimiser_schema(kind: str) -> type[BaseModel]:
    found: Any = optimiser_class(kind)
    hints = get_type_hints(found)
    options: dict[str, Any] = {field.name: (hints[field.name], field.default) for field in fields(found)}
    return create_model("optimiser", __base__=Section, **({"name": (str, ...), "kind": (str, ...)} | options))


def _checked(schema: type[BaseModel], group: str, raw: Mapping[str, Any]) -> dict[str, Any]:
    try:
        return schema.model_validate(dict(raw)).model_dump()
    except ValidationError as error:
        raise UserError("\n".join(lines(error, raw, group))) from None
