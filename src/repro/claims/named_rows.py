"""Reading a YAML file that is a list of named rows."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from repro.errors import UserError


def read_rows(path: Path, what: str) -> list[Any]:
    """The rows of a file, a list of `what`. Raises UserError when it cannot be read or is no list."""
    import yaml

    try:
        rows = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        message = f"{path} cannot be read: {error}"
        raise UserError(message) from error
    if not isinstance(rows, list):
        message = f"{path} must be a list of {what}"
        raise UserError(message)
    return rows


def check_apart(path: Path, names: Sequence[str], mend: str) -> None:
    """Raise UserError when a name stands in the file twice; mend: what to do then."""
    if repeated := sorted({name for name in names if names.count(name) > 1}):
        message = f"{path.name}: {', '.join(repeated)} stands there twice; {mend}"
        raise UserError(message)
