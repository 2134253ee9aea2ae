"""An executable reading of one paper: learned Lagrangians, port-Hamiltonian structure and energy-based control."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

    from repro.tracking.load import Run


def load_run(id: str, *, root: Path | None = None) -> Run:
    """One stored run with its card, tables, data, model and weights; see `repro.pipeline.finished_run.OpenedRun`."""
    from repro.pipeline.finished_run import open_run

    return open_run(id, root=root)


def load_runs(*, root: Path | None = None, **filters: Any) -> pd.DataFrame:
    """All finished runs as one tidy table, filtered by columns; see `repro.tracking.load.load_runs`."""
    from repro.tracking import load

    return load.load_runs(root=root, **filters)
