"""Ids of stages as people type them: whole, their start, or the digits at their end."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from repro.errors import UserError
from repro.tracking.paths import Paths

_MOST_LISTED = 5


def digits(id: str) -> str:
    """The digits at the end of an id, which alone identify it."""
    return id.rpartition("-")[2]


def matching(ids: Iterable[str], text: str) -> list[str]:
    """The ids that a text names: the one that equals it, else those that start with it, or whose digits do."""
    candidates = list(ids)
    if text in candidates:
        return [text]
    return [id for id in candidates if id.startswith(text) or digits(id).startswith(text)]


def resolve(paths: Paths, text: str) -> Path:
    """The folder of the one stage that a text names, among the finished ones first, then among the failures.

    Raises UserError when none or several fit.
    """
    for shelf in ("", ".failed"):
        folders = {id: paths.root / kind / shelf / id for kind in paths.kinds() for id in paths.ids(kind, shelf)}
        fitting = matching(folders, text)
        if len(fitting) == 1:
            return folders[fitting[0]]
        if fitting:
            some = ", ".join(fitting[:_MOST_LISTED]) + (", ..." if len(fitting) > _MOST_LISTED else "")
            raise UserError(f"{text} fits {len(fitting)} stages: {some}; type more of the id")
    raise UserError(f"no stage {text} under {paths.root}; `repro runs` lists the ids")
