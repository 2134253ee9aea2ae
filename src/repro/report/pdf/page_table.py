"""A table of the report made narrow enough for a page: one column names a row, intervals go below their medians."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from repro.report.tables.table import Table
from repro.results.metric_names import METRICS

# Of a table of models a page has room for this much; the whole table lies beside the report as CSV.
LEFT_OUT = ("median AE q̈", "MAE L relative", "skill τ", "skill q̈", "stale")
MEASURED = {"loops", *(metric.label for metric in METRICS.values())} - {"epochs"}
# What a setting that is not named otherwise has.
SILENT = ("", "–", "0", "false", "lagrangian", "no")

PORTRAIT, LANDSCAPE = 481.0, 728.0  # points between the margins of A4
SIZES = (7.5, 7.0, 6.5)
CHARACTER = 0.5  # of the size, on average
BOLD = 1.1
BELOW = 0.88  # size of an interval, of that of its median
GAP = 7.5  # points between two columns
UNBROKEN = 8  # rows up to which a table stays on one page
TEXT = 18  # characters from which on a cell is text that may break
SHORT, LONG = 22.0, 34.0  # characters a line that text gets at least; the longer where it would fill many lines
LINES, READABLE = 3, 55
ZERO_WIDTH_SPACE = "\u200b"


@dataclass(frozen=True)
class Grid:
    """The titles and cells of a table as they are shown."""

    titles: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def page_table(table: Table) -> dict[str, Any]:
    """Return titles, rows of {main, below}, column kinds (number, text), font size and orientation."""
    grid, shared = _without_shared_columns(_named_in_one_column(_without(table, LEFT_OUT)))
    kinds = ["text" if _is_text(grid, place) else "number" for place in range(len(grid.titles))]
    least = [_least_characters(grid, place, kind) for place, kind in enumerate(kinds)]
    landscape, size = _layout(least)
    whole = [_least_characters(grid, place, kind, broken=False) for place, kind in enumerate(kinds)]
    widths = _widths(least, whole, size, LANDSCAPE if landscape else PORTRAIT)
    return {
        "name": table.name,
        "title": table.title,
        "caption": table.caption,
        "shared": shared,
        "unbroken": len(table.rows) <= UNBROKEN,
        "titles": list(grid.titles),
        "kinds": kinds,
        "aligned": ["left" if place == 0 or _is_worded(grid, place) else "right" for place in range(len(kinds))],
        "widths": widths,
        "weights": [_weight(grid, place) for place in range(len(grid.titles))],
        "size": size,
        "landscape": landscape,
        "anchors": [row.anchor for row in table.rows],
        "rows": [[_cell(cell) for cell in row] for row in grid.rows],
    }


def _without(table: Table, titles: Sequence[str]) -> Grid:
    kept = [place for place, title in enumerate(table.columns) if title not in titles]
    return Grid(
        tuple(table.columns[place] for place in kept),
        tuple(tuple(row.cells[place] for place in kept) for row in table.rows),
    )


def _named_in_one_column(grid: Grid) -> Grid:
    """Join the columns before the first measured one; a table without such columns stays as it is."""
    first = next((place for place, title in enumerate(grid.titles) if _is_measured(title)), 0)
    if first < 2:
        return grid
    names = grid.titles[:first]
    rows = tuple((_name(names, row[:first]), *row[first:]) for row in grid.rows)
    return Grid(("setting", *grid.titles[first:]), rows)


def _is_measured(title: str) -> bool:
    return re.sub(r"\[\d+\]$", "", title.removesuffix(" on D_H")) in MEASURED


def _name(titles: Sequence[str], cells: Sequence[str]) -> str:
    parts = []
    for title, cell in zip(titles, cells, strict=True):
        if cell in SILENT:
            continue
        if cell == "true":
            parts.append(title)
        else:
            bare = re.fullmatch(r"-?[\d.e-]+", cell) is not None
            parts.append(f"{title} {cell}" if bare else cell)
    return ", ".join(parts)


def _without_shared_columns(grid: Grid) -> tuple[Grid, str]:
    """Take out the columns that say the same in every row, and say once what they say."""
    if len(grid.rows) < 2:
        return grid, ""
    values = [{row[place] for row in grid.rows} for place in range(len(grid.titles))]
    kept = [place for place, found in enumerate(values) if place == 0 or len(found) > 1]
    said = [
        f"{title} {min(found)}"
        for place, (title, found) in enumerate(zip(grid.titles, values, strict=True))
        if place not in kept and min(found) not in SILENT
    ]
    rows = tuple(tuple(row[place] for place in kept) for row in grid.rows)
    return Grid(tuple(grid.titles[place] for place in kept), rows), ", ".join(said)


def _cell(text: str) -> dict[str, str]:
    # An interval is secondary to its median and goes below it.
    parts = re.fullmatch(r"(\S+) (\[[^\]]*\])", text)
    return {"main": parts[1], "below": parts[2]} if parts else {"main": _breakable(text), "below": ""}


def _breakable(text: str) -> str:
    """Let a long setting such as optimiser.epochs=1000 break after its dots, underscores and equals signs."""
    return re.sub(r"(?<=\w[._=])(?=\w)(?<!\d\.)", ZERO_WIDTH_SPACE, text) if "=" in text else text


def _is_text(grid: Grid, place: int) -> bool:
    mains = (_cell(row[place])["main"] for row in grid.rows)
    return any(len(main) > TEXT and " " in main for main in mains)


def _is_worded(grid: Grid, place: int) -> bool:
    """Whether most of what stands in a column begins with a letter: words are set to the left, numbers to the right."""
    filled = [row[place] for row in grid.rows if row[place] not in ("", "–")]
    return sum(cell[:1].isalpha() for cell in filled) > len(filled) / 2


def _least_characters(grid: Grid, place: int, kind: str, *, broken: bool = True) -> float:
    """Return the length of what must not break: words of text; a median, and its interval or, broken, either end."""
    parts = [BOLD * len(word) for word in grid.titles[place].split()]
    for row in grid.rows:
        cell = _cell(row[place])
        parts += [len(word) for word in (cell["main"].split() if kind == "text" else [cell["main"]])]
        parts += [BELOW * len(part) for part in (cell["below"].split() if broken else [cell["below"]])]
    if kind == "number":
        return max(parts)
    longest = max(len(row[place]) for row in grid.rows)
    return max(min(longest, READABLE) if not broken else SHORT if longest <= LINES * SHORT else LONG, *parts)


def _widths(least: Sequence[float], whole: Sequence[float], size: float, page: float) -> list[float]:
    """Return widths in points: whole intervals where the page has room for all, else what must not break."""
    for characters in (whole, least):
        widths = [round(count * CHARACTER * size + GAP, 1) for count in characters]
        if sum(widths) <= page:
            break
    return widths


def _weight(grid: Grid, place: int) -> float:
    lengths = [len(row[place]) for row in grid.rows]
    return round((sum(lengths) / max(len(lengths), 1)) ** 0.7 + 4, 1)


def _layout(least: Sequence[float]) -> tuple[bool, float]:
    for landscape, width in ((False, PORTRAIT), (True, LANDSCAPE)):
        for size in SIZES:
            if sum(least) * CHARACTER * size + GAP * len(least) <= width:
                return landscape, size
    return True, SIZES[-1]
