"""One table, written as CSV (every digit), Markdown and LaTeX (for people)."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from repro.report import writing
from repro.tracking.files import write_text


@dataclass(frozen=True)
class Column:
    """A column's heading, as plain text and as LaTeX."""

    title: str
    latex: str = ""

    @property
    def latex_title(self) -> str:
        """The heading in LaTeX; the plain one, escaped, where no other is given."""
        return self.latex or writing.latex(self.title)


@dataclass(frozen=True)
class Row:
    """The cells as people read them, the same at full precision by name, and what the row was made from."""

    cells: tuple[str, ...]
    data: Mapping[str, Any]
    runs: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()
    anchor: bool = False


@dataclass(frozen=True)
class Table:
    """A named table with a caption; `note` explains its signs."""

    name: str
    title: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...] = field(repr=False)

    def save(self, folder: Path) -> list[Path]:
        """Write <name>.csv, <name>.md and <name>.tex, each atomically."""
        written = {".csv": self.csv(), ".md": self.markdown(), ".tex": self.latex()}
        for suffix, text in written.items():
            write_text(folder / f"{self.name}{suffix}", text)
        return [folder / f"{self.name}{suffix}" for suffix in written]

    def csv(self) -> str:
        """All rows at full precision, with runs and commands."""
        names = list(dict.fromkeys(name for row in self.rows for name in row.data))
        text = io.StringIO()
        writer = csv.DictWriter(text, [*names, "runs", "command"], lineterminator="\n")
        writer.writeheader()
        for row in self.rows:
            writer.writerow({**row.data, "runs": " ".join(row.runs), "command": " && ".join(row.commands)})
        return text.getvalue()

    def markdown(self, *, replay: bool = True) -> str:
        """Return a Markdown page: title, caption, table; `replay` adds the command that makes each row again."""
        lines = [f"# {self.title}", "", self.caption, "", *self.markdown_rows(replay=replay)]
        return "\n".join(lines) + "\n"

    def markdown_rows(self, *, replay: bool = True) -> list[str]:
        """Return the lines of the Markdown table alone."""
        titles = [writing.markdown(column.title) for column in self.columns] + ["replay"] * replay
        lines = [_line(titles), _line(["---"] * len(titles))]
        for row in self.rows:
            command = " && ".join(row.commands).replace("|", r"\|")
            cells = [writing.markdown(cell) for cell in row.cells]
            lines.append(_line([*cells, *([f"`{command}`" if command else ""] * replay)]))
        return lines

    def latex(self) -> str:
        """Return a LaTeX table (booktabs); above each row, as a comment, the command that makes it again."""
        lines = [
            r"\begin{table}",
            rf"\caption{{{writing.latex(self.title)}. {writing.latex(self.caption)}}}",
            rf"\label{{tab:{self.name}}}",
            r"\centering",
            rf"\begin{{tabular}}{{{'l' * len(self.columns)}}}",
            r"\toprule",
            " & ".join(column.latex_title for column in self.columns) + r" \\",
            r"\midrule",
        ]
        for row in self.rows:
            lines += [f"% replay: {command}" for command in row.commands]
            lines.append(" & ".join(writing.latex(cell) for cell in row.cells) + r" \\")
        return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table}"]) + "\n"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
