"""The verdicts in the terminal, and where everything lies."""

import os
from collections.abc import Mapping, Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from repro.claims.assumption_effects import AssumptionEffect
from repro.claims.verdict_kind import VerdictKind
from repro.report.summary import Summary
from repro.report.tables.sensitivity import change
from repro.report.writing import number

WIDE = 110

COLOURS = {
    VerdictKind.CONSISTENT: "green",
    VerdictKind.SUPPORTED: "green",
    VerdictKind.WITH_CHANGES: "bright_blue",
    VerdictKind.OUTSIDE: "dark_orange",
    VerdictKind.NOT_SUPPORTED: "dark_orange",
    VerdictKind.UNDECIDED: "yellow",
}


def show(summary: Summary, console: Console | None = None) -> None:
    """Print the verdicts (in a narrow terminal the medians alone), what has not been run, and where everything lies."""
    console = console or Console()
    answered = [line for line in summary.verdicts if line["verdict"] != VerdictKind.NOT_RUN]
    console.print(_verdict_table(answered, summary.scale, wide=console.width >= WIDE))
    flagged = [line["claim"] for line in answered if line["flag"]]
    if flagged:
        console.print(f"† a trivial, degenerate or oracle row satisfies it too: {', '.join(flagged)}", highlight=False)
    unanswered = [line["claim"] for line in summary.verdicts if line["verdict"] == VerdictKind.NOT_RUN]
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


def show_sensitivity(compared: Sequence[AssumptionEffect], console: Console | None = None) -> None:
    """Print what was tried for each assumption and which way claims lean then; in a narrow terminal without values."""
    console = console or Console()
    wide = console.width >= WIDE
    values = ("ours", "instead") if wide else ()
    table = _table("", ("assumption", "*instead", "claim", *(f">{title}" for title in values), "leaning"), wide=True)
    before = ""
    for each in compared:
        numbers = [number(each.ours.estimate.median), number(each.other.estimate.median)] if wide else []
        name, before = ("" if each.assumption == before else each.assumption), each.assumption
        verdict = Text(change(each), style="bold" if each.moved else "dim")
        table.add_row(name, Text(each.alternative), each.ours.claim.name, *numbers, verdict)
    console.print(table)
    moved = len({each.assumption for each in compared if each.moved})
    tried = len({each.assumption for each in compared})
    console.print(f"{moved} of {tried} assumptions move an answer; scale quick, few members", highlight=False)


def _verdict_table(lines: Sequence[Mapping[str, str]], scale: str, *, wide: bool) -> Table:
    ours = (">ours \\[95 %]", ">members") if wide else (">ours",)
    titles = ("claim", "*what the paper says", ">printed", *ours, "verdict" if wide else "*verdict")
    table = _table(f"Verdicts, scale {scale or 'unknown'}", titles, wide=wide)
    for line in lines:
        values = [Text(line["ours"]), line["members"]] if wide else [line["median"]]
        verdict = Text(line["marked"] + " †" * bool(line["flag"]), style=COLOURS.get(VerdictKind(line["verdict"]), ""))
        table.add_row(line["claim"], Text(line["about"]), line["printed"], *values, verdict)
    return table


def _table(title: str, columns: Sequence[str], *, wide: bool) -> Table:
    """An empty table; a column that begins with > holds numbers, one with * takes the room that the others leave."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, expand=True, title=title or None, title_justify="left")
    for column in columns:
        if column.startswith("*"):
            table.add_column(column[1:], ratio=1, no_wrap=wide, overflow="ellipsis" if wide else "fold")
        else:
            table.add_column(column.lstrip(">"), justify="right" if column[0] == ">" else "left", no_wrap=True)
    return table
