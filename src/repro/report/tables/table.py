"""One table, written as CSV (every digit) and Markdown (for people)."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from repro.report import writing
from repro.results.run_setting import RunSetting
from repro.tracking.files import write_text


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
        cls, settings: Sequence[RunSetting], cells: Sequence[str], data: Mapping[str, Any], *, anchor: bool = False
    ) -> Self:
        """Make a row from settings, whose runs and commands it then names."""
        runs = tuple(run for setting in settings for run in setting.run_ids)
        commands = tuple(setting.command for setting in settings if setting.command)
        return cls(tuple(cells), data, runs, commands, anchor)


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
        write_text(folder / f"{self.name}.csv", self.csv())
        write_text(folder / f"{self.name}.md", self.markdown())

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
        lines = [f"# {self.title}", "", self.caption, "", *markdown_head(titles)]
        for row in self.rows:
            command = " && ".join(row.commands).replace("|", r"\|")
            cells = [writing.markdown(cell) for cell in row.cells]
            lines.append(markdown_line([*cells, f"`{command}`" if command else ""]))
        return "\n".join(lines) + "\n"


def markdown_head(titles: Sequence[str]) -> list[str]:
    """Return the first two lines of a Markdown table; the titles are escaped already."""
    return [markdown_line(titles), markdown_line(["---"] * len(titles))]


def markdown_line(cells: Sequence[str]) -> str:
    """Return one line of a Markdown table; the cells are escaped already."""
    return f"| {' | '.join(cells)} |"
