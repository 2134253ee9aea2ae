"""The run card: a plain dictionary as Markdown tables."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any


def markdown(title: str, card: Mapping[str, Any]) -> str:
    """A page with one table of the plain entries, then one section for each nested dictionary or list of rows.

    A dictionary of dictionaries is flattened to dotted keys; a list of dictionaries is a table with one column a key.
    """
    nested = {key: value for key, value in card.items() if isinstance(value, Mapping) or _is_rows(value)}
    plain = {key: value for key, value in card.items() if key not in nested}
    sections = [f"## {title}", *([_pairs("Run", plain)] if plain else [])]
    for key, value in nested.items():
        sections += [f"**{key}**", _rows(value)] if _is_rows(value) else [_pairs(key, value)]
    return "\n\n".join(sections) + "\n"


def flatten(card: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested dictionaries as one, with dotted keys; every other value is kept."""
    flat: dict[str, Any] = {}
    for key, value in card.items():
        path = f"{prefix}{key}"
        flat |= flatten(value, f"{path}.") if isinstance(value, Mapping) else {path: value}
    return flat


def _is_rows(value: Any) -> bool:
    return isinstance(value, Sequence) and len(value) > 0 and all(isinstance(row, Mapping) for row in value)


def _pairs(name: str, entries: Mapping[str, Any]) -> str:
    return _table((name, ""), flatten(entries).items())


def _rows(rows: Sequence[Mapping[str, Any]]) -> str:
    columns = list(dict.fromkeys(key for row in rows for key in row))
    return _table(columns, ([row.get(column, "") for column in columns] for row in rows))


def _table(header: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    lines = [header, ["---"] * len(header), *([_cell(value) for value in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(_cell(entry) for entry in value)
    return "–" if value is None else str(value).replace("|", "\\|").replace("\n", " ")
