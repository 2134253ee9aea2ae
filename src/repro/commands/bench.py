"""`repro bench`: paired timings, stored like any other result."""

import math
import sys
from collections.abc import Sequence

import pandas as pd
from rich import box
from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

from repro.bench.stored_bench import FILE, run
from repro.commands.arguments import command_parser
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.store import StageFailed

WIDE = 110  # columns of a terminal from which the times fit beside the ratios


def main(argv: Sequence[str]) -> int:
    """Run `repro bench`; 1 when a comparison failed."""
    parser = command_parser("bench")
    parser.add_argument("--scale", default="quick", choices=("smoke", "quick", "paper"), help="how much (quick)")
    scale = parser.parse_args(argv).scale
    root = outputs_root()
    try:
        id = run(root, scale)
    except StageFailed as failure:
        print(failure, file=sys.stderr)
        return 1
    folder = Paths(root).folder("bench", id)
    console = Console()
    times = ("ours ms", "other ms") if console.width >= WIDE else ()
    for name, rows in pd.read_parquet(folder / FILE).groupby("name", sort=False):
        ratios = Column("other / ours (quartiles)", justify="right", no_wrap=True)
        shown = [*map(Column, ("size", "ours", "other")), ratios, *(Column(title, justify="right") for title in times)]
        table = Table(*shown, box=box.SIMPLE_HEAD, title=str(name), title_justify="left")
        for row in rows.to_dict("records"):
            low, median, high = (row[f"ratio_{key}"] for key in ("q25", "median", "q75"))
            colour = "green" if low > 1 else "dark_orange" if high < 1 else ""
            size = row["size"] if row["members"] == 1 else f"{row['size']}, {row['members']} members"
            if row["metric"]:
                size += f", {row['metric']}" + ("" if math.isnan(row["goal"]) else f" {row['goal']:g}")
            ratio = Text(f"{median:.3g} ({low:.3g} to {high:.3g})", style=colour)
            spent = (row[title.replace(" ", "_")] for title in times)
            ms = ("not reached" if math.isinf(each) else f"{each:.3g}" for each in spent)
            table.add_row(size, row["ours"], row["other"], ratio, *ms)
        console.print(table)
    console.print(f"protocols and machine: {folder}", highlight=False, soft_wrap=True)
    return 0
