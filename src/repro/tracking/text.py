"""Plain text for the terminal."""

import os
import shutil
import sys
from collections.abc import Iterable, Sequence


def table(rows: Iterable[Sequence[object]], header: Sequence[str] = (), width: int | None = None) -> str:
    """Left-aligned columns, two blanks apart; numbers as str() writes them.

    With a width, as many columns are shown as fit, at least the first; what is left out is named below.
    """
    lines = [[str(cell) for cell in row] for row in ([header] if header else [])]
    lines += [[str(cell) for cell in row] for row in rows]
    if not lines:
        return ""
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    ends = [sum(widths[: count + 1]) + 2 * count for count in range(len(widths))]
    shown = len(widths) if width is None else max(1, sum(end <= width for end in ends))
    text = "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line[:shown], widths, strict=False)).rstrip()
        for line in lines
    )
    left_out = f"\n\nnot shown, for lack of width: {', '.join(header[shown:])}" if header[shown:] else ""
    return text + left_out


def terminal_width() -> int | None:
    """The width of the terminal, or $COLUMNS; None where the output goes to a file or to another program."""
    given = os.environ.get("COLUMNS", "").isdecimal()
    return shutil.get_terminal_size().columns if given or sys.stdout.isatty() else None


def short(value: object, width: int = 80) -> str:
    """A value on one short line: six digits of a number, the beginning of a long text, (none) for None."""
    if value is None:
        return "(none)"
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return text if len(text) <= width else text[: width - 3] + "..."


def duration(seconds: float) -> str:
    """A time in readable units: 0.4 s, 12 s, 3 min 20 s, 2 h 5 min."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
