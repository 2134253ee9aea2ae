"""One table, written as CSV (every digit) and Markdown (for people)."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from repro.report import writing
from repro.results.statistics import Estimate
from repro.results.table_schema import Row as ResultRow
from repro.tracking.files import write_text

RECORDED = ("run", "command")  # columns of the result tables


@dataclass(frozen=True)
class Row:
    """The cells as people read them, the same at full precision by name, and what the row was made from."""

    cells: tuple[str, ...]
    data: Mapping[str, Any]
    runs: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()
    anchor: bool = False

    @classmethod
    def of(
        cls,
        made_from: Sequence[ResultRow],
        values: Mapping[str, Any],
        texts: Mapping[str, str] | None = None,
        shown: Sequence[str] = (),
        *,
        anchor: bool = False,
    ) -> Self:
        """Make a row from values by name, and the rows of the result tables whose runs and commands it then names.

        An estimate is stored as its median, `NAME_low` and `NAME_high`. texts: what is shown of some in the place of
        their value; shown: the names of the cells, all values by default.
        """
        data: dict[str, Any] = {}
        for name, value in values.items():
            data[name] = value.median if isinstance(value, Estimate) else value
            if isinstance(value, Estimate):
                data |= {f"{name}_low": value.low, f"{name}_high": value.high}
        written = {name: writing.value(value) for name, value in values.items()} | dict(texts or {})
        cells = tuple(written.get(name, writing.ABSENT) for name in shown or values)
        runs, commands = (tuple(filter(None, dict.fromkeys(row[key] for row in made_from))) for key in RECORDED)
        return cls(cells, data, runs, commands, anchor)


@dataclass(frozen=True)
class Table:
    """A named table: title, caption, the titles of its columns, and its rows."""

    name: str
    title: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...] = field(repr=False)

    def save(self, folder: Path) -> None:
        """Write <name>.csv and <name>.md, each atomically."""
        write_text(folder / f"{self.name}.csv", self.csv(), forced=False)
        write_text(folder / f"{self.name}.md", self.markdown(), forced=False)

    def csv(self) -> str:
        """Return all rows at full precision, with runs and commands."""
        names = list(dict.fromkeys(name for row in self.rows for name in row.data))
        text = io.StringIO()
        writer = csv.DictWriter(text, [*names, "runs", "command"], lineterminator="\n")
        writer.writeheader()
        for row in self.rows:
            writer.writerow({**row.data, "runs": " ".join(row.runs), "command": " && ".join(row.commands)})
        return text.getvalue()

    def markdown(self) -> str:
        """Return a Markdown page: title, caption, table; the last column is the command that makes the row again."""
        titles = [*map(writing.markdown, self.columns), "replay"]
        commands = [" && ".join(row.commands).replace("|", r"\|") for row in self.rows]
        last = [f"`{command}`" if command else "" for command in commands]
        table = markdown_table(titles, [row.cells for row in self.rows], last)
        return f"# {self.title}\n\n{self.caption}\n\n{table}\n"


def markdown_table(titles: Sequence[str], rows: Iterable[Sequence[str]], last: Sequence[str] = ()) -> str:
    """Return a Markdown table; titles, and the cells of the `last` column where there is one, are escaped already."""
    lines = [titles, ["---"] * len(titles), *([writing.markdown(cell) for cell in row] for row in rows)]
    lines[2:] = [[*line, cell] for line, cell in zip(lines[2:], last, strict=True)] if last else lines[2:]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
