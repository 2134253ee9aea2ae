"""A bench as a stored stage: made once per machine, code and scale."""

import json
import os
import platform
import subprocess
import time
from pathlib import Path

import pandas as pd

from repro.bench import peers, suite
from repro.bench.pairing import PairedComparison, one_thread
from repro.bench.training_case import PENDULUM
from repro.codegen.c_library import compiler, has_compiler
from repro.tracking import progress
from repro.tracking.experiment_list import ExperimentList, ListedJob
from repro.tracking.files import write_json
from repro.tracking.paths import Paths
from repro.tracking.plain_data import Json
from repro.tracking.provenance import processor_name
from repro.tracking.stage import Stage
from repro.tracking.store import Store

EXPERIMENT = "timing"
FILE = "bench.parquet"
CHECKPOINT = "checkpoint.json"  # a file of this name stays in the working folder of a stage until it is finished
NOTICE_S = 2.0  # between two lines about the progress


def run(outputs: Path | str, scale: str) -> str:
    """Time everything of a scale unless this machine has a result of this code; the id of the stored bench.

    Lists it as the experiment `timing`. Rows measured before an interruption are not repeated. StageFailed where
    a comparison fails.
    """
    chosen = stage(scale)
    paths = Paths(Path(outputs).absolute())
    listed = ExperimentList(EXPERIMENT, scale, jobs=[ListedJob([], chosen.id, chosen.command)])
    listed.write(paths.experiments / scale / f"{EXPERIMENT}.json")
    return Store(paths.root).compute(chosen, lambda folder: _measure(folder, scale)).id


def stage(scale: str) -> Stage:
    """The identity of a bench: the scale, the machine, and the code that is timed."""
    return Stage(
        "bench",
        f"{EXPERIMENT}-{scale}",
        {"scale": scale, "machine": describe_machine()},
        {},
        ("repro.bench.suite", f"repro.mechanics.systems.{PENDULUM}"),
        f"repro bench --scale {scale}",
    )


def describe_machine() -> dict[str, object]:
    """What a timing depends on besides code and libraries, as plain data."""
    version = None
    if has_compiler():
        done = subprocess.run([compiler(), "--version"], capture_output=True, text=True, check=False)
        version = done.stdout.partition("\n")[0]
    return {
        "processor": processor_name(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "compiler": version,
    }


def _measure(folder: Path, scale: str) -> Json:
    if absent := peers.missing():
        progress.notice(f"left out: {', '.join(absent)}; to compare with them: pip install -e '.[peers]'")
    rows: list[dict[str, object]] = []
    with one_thread():
        planned, measured, noticed = suite.comparisons(scale), MeasuredRows(folder), time.monotonic()
        for number, comparison in enumerate(planned, start=1):
            if time.monotonic() - noticed > NOTICE_S:
                progress.notice(f"timing {number} of {len(planned)}: {comparison.label}")
                noticed = time.monotonic()
            rows.append(measured.row(comparison))
    pd.DataFrame(rows).to_parquet(folder / FILE, index=False)
    return {"comparisons": len(rows), "scale": scale}


class MeasuredRows:
    """The rows of a bench that may be interrupted, by label; each is stored as soon as it is measured."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / CHECKPOINT
        self._rows = json.loads(self.path.read_text()) if self.path.exists() else {}

    def row(self, comparison: PairedComparison) -> dict[str, object]:
        """The row of a comparison: the stored one, or a new measurement."""
        if comparison.label not in self._rows:
            self._rows[comparison.label] = comparison.row(comparison.measure())
            write_json(self.path, self._rows)
        return dict(self._rows[comparison.label])
