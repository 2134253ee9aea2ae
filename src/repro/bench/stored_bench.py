"""A bench as a stored stage: made once per machine, code and scale."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from repro.bench import machine
from repro.bench.training_case import PENDULUM
from repro.tracking import progress
from repro.tracking.files import write_json
from repro.tracking.paths import Paths
from repro.tracking.stage import Stage
from repro.tracking.store import Store

EXPERIMENT = "timing"
FILE = "bench.parquet"
NOTICE_S = 2.0  # between two lines about the progress


def run(outputs: Path, scale: str) -> str:
    """Time everything of a scale unless this machine has a result of this code; the id of the stored bench.

    Lists it as the experiment `timing`. Rows measured before an interruption are not repeated. Raises StageFailed
    when a comparison fails.
    """
    chosen = stage(scale)
    paths = Paths(Path(outputs).absolute())
    job = {"overrides": [], "run": chosen.id, "command": chosen.command}
    listed = {"experiment": EXPERIMENT, "scale": scale, "jobs": [job]}
    write_json(paths.experiments / scale / f"{EXPERIMENT}.json", listed)
    return Store(paths.root).compute(chosen, lambda folder: _measure(folder, scale)).id


def stage(scale: str) -> Stage:
    """The identity of a bench: the scale, the machine, and the code that is timed."""
    return Stage(
        "bench",
        f"{EXPERIMENT}-{scale}",
        {"scale": scale, "machine": machine.describe()},
        {},
        ("repro.bench.suite", "repro.bench.threads", f"repro.mechanics.systems.{PENDULUM}"),
        f"repro bench --scale {scale}",
    )


def _measure(folder: Path, scale: str) -> dict[str, Any]:
    import pandas as pd

    rows = list(_rows(scale, folder))
    pd.DataFrame(rows).to_parquet(folder / FILE, index=False)
    return {"comparisons": len(rows), "scale": scale}


def _rows(scale: str, folder: Path) -> Iterator[dict[str, object]]:
    from repro.bench.measured_rows import MeasuredRows
    from repro.bench.peers import missing
    from repro.bench.suite import comparisons
    from repro.bench.threads import one_thread

    if absent := missing():
        progress.notice(f"left out: {', '.join(absent)}; to compare with them: pip install -e '.[peers]'")
    with one_thread():
        planned, measured, noticed = comparisons(scale), MeasuredRows(folder), time.monotonic()
        for number, comparison in enumerate(planned, start=1):
            if time.monotonic() - noticed > NOTICE_S:
                progress.notice(f"timing {number} of {len(planned)}: {comparison.label}")
                noticed = time.monotonic()
            yield measured.row(comparison)
