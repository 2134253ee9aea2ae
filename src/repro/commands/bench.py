"""`repro bench`: paired timings, stored like any other result."""

import math
import sys
from argparse import Namespace
from typing import Any

import pandas as pd

from repro.bench.stored_bench import FILE, run
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.store import StageFailed
from repro.tracking.text import table, terminal_width

COLUMNS = ("size", "ours", "other", "other / ours (quartiles)", "ours ms", "other ms")


def main(arguments: Namespace) -> int:
    """Run `repro bench`; 1 when a comparison failed."""
    scale = arguments.scale
    root = outputs_root()
    try:
        id = run(root, scale)
    except StageFailed as failure:
        print(failure, file=sys.stderr)
        return 1
    folder = Paths(root).folder("bench", id)
    for name, rows in pd.read_parquet(folder / FILE).groupby("name", sort=False):
        print(f"{name}\n{table(map(_cells, rows.itertuples()), COLUMNS, terminal_width())}\n")
    print(f"protocols and machine: {folder}")
    return 0


def _cells(row: Any) -> list[str]:
    size = row.size if row.members == 1 else f"{row.size}, {row.members} members"
    if row.metric:
        size += f", {row.metric}" + ("" if math.isnan(row.goal) else f" {row.goal:g}")
    ratio = f"{row.ratio_median:.3g} ({row.ratio_q25:.3g} to {row.ratio_q75:.3g})"
    times = ("not reached" if math.isinf(ms) else f"{ms:.3g}" for ms in (row.ours_ms, row.other_ms))
    return [size, row.ours, row.other, ratio, *times]
