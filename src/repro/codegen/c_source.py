"""C that lies in files of its own: read, and its ${names} filled in."""

from functools import cache
from pathlib import Path
from string import Template


def c_source(module: str, name: str, **values: object) -> str:
    """Text of the file NAME.c beside a module (its `__file__`), with every ${key} replaced.

    Raises KeyError for a key without a value. The files of a folder belong to the code of its package: a stage that
    imports from there is made anew when one of them changes.
    """
    text = _text(Path(module).with_name(f"{name}.c"))
    return Template(text).substitute({key: str(value) for key, value in values.items()}) if values else text


@cache
def _text(path: Path) -> str:
    return path.read_text()
