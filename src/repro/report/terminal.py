"""The verdicts in the terminal, and where everything lies."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from repro.report.summary import Summary

if TYPE_CHECKING:
    from rich.console import Console

COLOURS = {
    "matched": "green",
    "better": "bright_blue",
    "worse": "dark_orange",
    "not reproduced": "dark_orange",
    "inconclusive": "yellow",
}


def show(summary: Summary, console: "Console | None" = None) -> None:
    """Print the verdict table, what has not been run, and the places of report, figures, tables and recordings."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = console or Console()
    table = Table(box=box.SIMPLE_HEAD, title=f"Verdicts, scale {summary.scale or 'unknown'}", title_justify="left")
    table.add_column("claim", no_wrap=True)
    table.add_column("what the paper says", ratio=1)
    for title in ("printed", "ours \\[95 %]", "members"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("verdict")
    answered = [line for line in summary.verdicts if line.verdict != "not run"]
    for line in answered:
        verdict = Text(line.marked, style=COLOURS.get(line.verdict, ""))
        if line.flag:
            verdict.append(f"; {line.flag}", style="dim")
        table.add_row(line.claim, Text(line.about), line.printed, Text(line.ours), line.members, verdict)
    console.print(table)
    unanswered = [line.claim for line in summary.verdicts if line.verdict == "not run"]
    if unanswered:
        console.print(f"not run: {', '.join(unanswered)}", style="dim", highlight=False)
    counts = [f"{summary.runs} runs"]
    counts += [f"{summary.absent} failed or missing (repro status)"] if summary.absent else []
    counts += [f"{summary.stale} stale (the code has changed since)"] if summary.stale else []
    console.print(", ".join(counts), highlight=False)
    console.print()
    places = {
        "report": summary.page,
        "figures": summary.figures,
        "tables": summary.tables,
        "results": summary.results,
        "recordings": summary.recordings,
    }
    for title, place in places.items():
        if place.exists():
            console.print(f"{title:<11}{_short(place)}", highlight=False, soft_wrap=True)


def _short(path: Path) -> str:
    relative = os.path.relpath(path)
    return str(path) if relative.startswith("..") else relative
