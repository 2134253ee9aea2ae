"""The run card as a page: a plain nested dictionary as Markdown tables."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeGuard

from repro.tracking.plain_data import flattened


def card_page(title: str, card: Mapping[str, object]) -> str:
    """A page with one table of the plain entries, then one section for each nested dictionary or list of rows.

    A dictionary of dictionaries is flattened to dotted keys; a list of dictionaries is a table with one column per key.
    """
    sections = []
    plain = {}
    for key, value in card.items():
        if isinstance(value, Mapping):
            sections.append(_pairs(key, value))
        elif _is_rows(value):
            sections += [f"**{key}**", _rows(value)]
        else:
            plain[key] = value
    sections = [f"## {title}", *([_pairs("Run", plain)] if plain else []), *sections]
    return "\n\n".join(sections) + "\n"


def _is_rows(value: object) -> TypeGuard[Sequence[Mapping[str, object]]]:
    return isinstance(value, Sequence) and len(value) > 0 and all(isinstance(row, Mapping) for row in value)


def _pairs(name: str, entries: Mapping[str, object]) -> str:
    return _table((name, ""), flattened(entries).items())


def _rows(rows: Sequence[Mapping[str, object]]) -> str:
    columns = list(dict.fromkeys(key for row in rows for key in row))
    return _table(columns, ([row.get(column, "") for column in columns] for row in rows))


def _table(header: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    lines = [header, ["---"] * len(header), *([_cell(value) for value in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(_cell(entry) for entry in value)
    return "–" if value is None else str(value).replace("|", "\\|").replace("\n", " ")
