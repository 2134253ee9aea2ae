"""The progress of work in this process: a bar with the time left in a terminal, a line per step elsewhere."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from repro.tracking import progress


@contextmanager
def shown(title: str) -> Iterator[None]:
    """Show what the block reports as progress, on standard error."""
    if not sys.stderr.isatty():
        with progress.watched(lambda fraction, text: print(f"{title}: {text}", file=sys.stderr, flush=True)):
            yield
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        bar = bars.add_task(title, total=1.0)
        with progress.watched(lambda fraction, text: bars.update(bar, completed=fraction or 0.0, description=text)):
            yield
