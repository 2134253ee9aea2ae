"""The verdicts in the terminal, and where everything lies."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from repro.claims.assumption_effects import AssumptionEffect
from repro.claims.verdict_kind import VerdictKind
from repro.report.summary import Summary, VerdictLine
from repro.report.tables.sensitivity import change
from repro.report.writing import ABSENT, number

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

WIDE = 110

COLOURS = {
    VerdictKind.CONSISTENT: "green",
    VerdictKind.SUPPORTED: "green",
    VerdictKind.WITH_CHANGES: "bright_blue",
    VerdictKind.OUTSIDE: "dark_orange",
    VerdictKind.NOT_SUPPORTED: "dark_orange",
    VerdictKind.UNDECIDED: "yellow",
}


def show(summary: Summary, console: "Console | None" = None) -> None:
    """Print the verdict table, what has not been run, and the places of report, figures, tables and recordings.

    A narrow terminal gets the medians alone; the report has everything.
    """
    from rich.console import Console

    console = console or Console()
    answered = [line for line in summary.verdicts if line.members != ABSENT]
    console.print(_table(answered, summary.scale, wide=console.width >= WIDE))
    flagged = [line.claim for line in answered if line.flag]
    if flagged:
        console.print(f"† a trivial, degenerate or oracle row satisfies it too: {', '.join(flagged)}", highlight=False)
    unanswered = [line.claim for line in summary.verdicts if line.members == ABSENT]
    if unanswered:
        console.print(f"not run: {', '.join(unanswered)}", style="dim", highlight=False)
    console.print(summary.headline, highlight=False)
    counts = [f"{summary.runs} runs"]
    counts += [f"{summary.absent} failed or missing (repro status)"] if summary.absent else []
    counts += [f"{summary.stale} stale (the code has changed since)"] if summary.stale else []
    console.print(", ".join(counts), highlight=False)
    console.print()
    names = {"report": "index.html", "paper": "report.pdf"} | dict.fromkeys(("figures", "tables", "results"), "")
    places = {title: summary.folder / (name or title) for title, name in names.items()}
    for title, place in {**places, "recordings": summary.recordings}.items():
        if place.exists():
            near = os.path.relpath(place)
            shown = place if near.startswith("..") else near
            console.print(f"{title:<11}{shown}", highlight=False, soft_wrap=True)


def show_sensitivity(compared: Sequence[AssumptionEffect], console: "Console | None" = None) -> None:
    """Print what was put in the place of each assumption, and which way each claim leans then.

    A narrow terminal gets the verdicts alone.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = console or Console()
    wide = console.width >= WIDE
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, expand=True)
    table.add_column("assumption", no_wrap=True)
    table.add_column("instead", ratio=1, no_wrap=True, overflow="ellipsis")
    table.add_column("claim", no_wrap=True)
    for title in ("ours", "instead") if wide else ():
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("leaning", no_wrap=True)
    before = ""
    for each in compared:
        values = [number(each.ours.estimate.median), number(each.other.estimate.median)] if wide else []
        name, before = ("" if each.assumption == before else each.assumption), each.assumption
        verdict = Text(change(each), style="bold" if each.moved else "dim")
        table.add_row(name, Text(each.alternative), each.ours.claim.name, *values, verdict)
    console.print(table)
    moved = len({each.assumption for each in compared if each.moved})
    tried = len({each.assumption for each in compared})
    console.print(f"{moved} of {tried} assumptions move an answer; scale quick, few members", highlight=False)


def _table(lines: Sequence[VerdictLine], scale: str, *, wide: bool) -> "Table":
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, expand=True)
    table.title, table.title_justify = f"Verdicts, scale {scale or 'unknown'}", "left"
    table.add_column("claim", no_wrap=True)
    table.add_column("what the paper says", ratio=1, no_wrap=wide, overflow="ellipsis" if wide else "fold")
    table.add_column("printed", justify="right", no_wrap=True)
    table.add_column("ours \\[95 %]" if wide else "ours", justify="right", no_wrap=True)
    if wide:
        table.add_column("members", justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for line in lines:
        ours = line.ours if wide else line.ours.partition(" [")[0]
        verdict = Text(line.marked + " †" * bool(line.flag), style=COLOURS.get(VerdictKind(line.verdict), ""))
        members = [line.members] if wide else []
        table.add_row(line.claim, Text(line.about), line.printed, Text(ours), *members, verdict)
    return table
