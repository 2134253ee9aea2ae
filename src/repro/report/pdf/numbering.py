"""The numbers of tables and figures, in the order in which they are read."""

from typing import Any

from repro.report.pdf.page_table import page_table
from repro.report.tables.table import Table


class Numbers:
    """Counts tables and figures as they come; a caption that has been read is not printed again."""

    def __init__(self) -> None:
        self.tables = 0
        self.figures = 0
        self.captions: dict[str, int] = {}

    def table(self, table: Table) -> dict[str, Any]:
        """Return a table for the page, with its number."""
        entry = page_table(table) | {"number": self.next_table()}
        first = self.captions.setdefault(table.caption, entry["number"])
        return entry if first == entry["number"] else entry | {"caption": f"To be read as Table {first}."}

    def next_table(self) -> int:
        """Return the next table's number."""
        self.tables += 1
        return self.tables

    def next_figure(self) -> int:
        """Return the next figure's number."""
        self.figures += 1
        return self.figures
