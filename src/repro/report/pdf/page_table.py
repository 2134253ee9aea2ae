"""A table of the report made narrow enough for a page: one column names a row, shared values move to the caption."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from repro.report.tables.table import Table
from repro.results.metric_names import vocabulary

# Of a table of models a page has room for this much; the whole table is beside the report as CSV.
LEFT_OUT = ("median AE q̈", "MAE L relative", "skill τ", "skill q̈", "stale")
# Values that need no mention in the name of a row.
SILENT = ("", "–", "0", "false", "lagrangian", "no")
TEXT = 18  # characters from which on a cell is text that may break, in lines of at least WRAPPED characters
WRAPPED = 28
GAP = 2  # characters between two columns
BOLD = 1.15  # width of a title's characters, in those of a cell
# Characters side by side on a page, whether it is turned, and the size of the font in points.
LAYOUTS = ((128, False, 7.5), (148, False, 6.5), (194, True, 7.5), (224, True, 6.5))
UNBROKEN = 8  # rows up to which a table stays on one page


@dataclass(frozen=True)
class Grid:
    """The titles and cells of a table as they are shown."""

    titles: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def columns(self, places: Sequence[int]) -> "Grid":
        """Return some of the columns."""
        rows = (tuple(row[place] for place in places) for row in self.rows)
        return Grid(tuple(self.titles[place] for place in places), tuple(rows))


def page_table(table: Table) -> dict[str, Any]:
    """Return titles, rows of {main, below}, sides of alignment, font size and orientation.

    `widths` are those of columns of text, in characters; 0 for a column of numbers, whose width typst finds.
    """
    grid = Grid(table.columns, tuple(row.cells for row in table.rows))
    grid = grid.columns([place for place, title in enumerate(grid.titles) if title not in LEFT_OUT])
    grid, shared = _without_shared_columns(_named_in_one_column(grid))
    least = sum(_least(grid, place) for place in range(len(grid.titles)))
    page, landscape, size = next((layout for layout in LAYOUTS if least <= layout[0]), LAYOUTS[-1])
    return {
        "name": table.name,
        "title": table.title,
        "caption": table.caption,
        "shared": shared,
        "unbroken": len(table.rows) <= UNBROKEN,
        "titles": list(grid.titles),
        "aligned": [_side(grid, place) for place in range(len(grid.titles))],
        "widths": _widths(grid, page),
        "size": size,
        "landscape": landscape,
        "anchors": [row.anchor for row in table.rows],
        "rows": [[_cell(cell) for cell in row] for row in grid.rows],
    }


def _named_in_one_column(grid: Grid) -> Grid:
    """Join the columns before the first measured one; a table without such columns stays as it is."""
    first = next((place for place, title in enumerate(grid.titles) if _is_measured(title)), 0)
    if first < 2:
        return grid
    names = grid.titles[:first]
    rows = tuple((_name(names, row[:first]), *row[first:]) for row in grid.rows)
    return Grid(("setting", *grid.titles[first:]), rows)


def _is_measured(title: str) -> bool:
    label = re.sub(r"(\[\d+\]|, \d+ links)$", "", title.removesuffix(" on D_H"))
    metrics = [*vocabulary().metrics.values(), *vocabulary().of_chains.values()]
    return label == "loops" or (label != "epochs" and any(label == metric.label for metric in metrics))


def _name(titles: Sequence[str], cells: Sequence[str]) -> str:
    parts = []
    for title, cell in zip(titles, cells, strict=True):
        if cell == "true":
            parts.append(title)
        elif cell not in SILENT:
            parts.append(f"{title} {cell}" if re.fullmatch(r"-?[\d.e-]+", cell) else cell)
    return ", ".join(parts)


def _without_shared_columns(grid: Grid) -> tuple[Grid, str]:
    """Take out the columns that hold one value in every row, and spell these values once."""
    if len(grid.rows) < 2:
        return grid, ""
    values = [{row[place] for row in grid.rows} for place in range(len(grid.titles))]
    retained = [place for place, distinct in enumerate(values) if place == 0 or len(distinct) > 1]
    shared = [(grid.titles[place], min(values[place])) for place in range(len(values)) if place not in retained]
    return grid.columns(retained), ", ".join(f"{title} {value}" for title, value in shared if value not in SILENT)


def _cell(text: str) -> dict[str, str]:
    # An interval is secondary to its median and goes below it.
    parts = re.fullmatch(r"(\S+) (\[[^\]]*\])", text)
    if parts:
        return {"main": parts[1], "below": parts[2]}
    # A long setting such as optimiser.epochs=1000 may break after its dots, underscores and equals signs.
    breakable = re.sub(r"(?<=\w[._=])(?=\w)(?<!\d\.)", "\u200b", text) if "=" in text else text
    return {"main": breakable, "below": ""}


def _side(grid: Grid, place: int) -> str:
    """Set words and text, of which most cells begin with a letter or are long, to the left, numbers to the right."""
    filled = [row[place] for row in grid.rows if row[place] not in ("", "–")]
    worded = sum(cell[:1].isalpha() for cell in filled) > len(filled) / 2
    return "left" if place == 0 or worded or _is_text(grid, place) else "right"


def _is_text(grid: Grid, place: int) -> bool:
    return any(len(row[place]) > TEXT and " " in row[place] and not row[place].endswith("]") for row in grid.rows)


def _least(grid: Grid, place: int) -> int:
    """Return the characters that a column needs at least: its longest word, or a line of text; titles are bold."""
    longest = max((len(word) for row in grid.rows for word in row[place].split()), default=0)
    title = max(round(BOLD * len(word)) for word in grid.titles[place].split())
    return GAP + max(longest, title, WRAPPED if _is_text(grid, place) else 0)


def _widths(grid: Grid, page: int) -> list[int]:
    """Share what columns of numbers leave of a page, their intervals unbroken, among those of text by their length."""
    least, lengths, numbers = [], [], 0
    for place in range(len(grid.titles)):
        cells = [row[place] for row in grid.rows]
        text = _is_text(grid, place)
        least.append(_least(grid, place) if text else 0)
        lengths.append(sum(map(len, cells)) if text else 0)
        parts = [part for cell in cells for part in _cell(cell).values()]
        numbers += 0 if text else max(_least(grid, place), GAP + max(map(len, parts), default=0))
    spare = max(0, page - numbers - sum(least))
    return [needed + spare * length // max(1, sum(lengths)) for needed, length in zip(least, lengths, strict=True)]
