"""Which runs are older than the code that would make them now."""

from pathlib import Path


def stale_runs(outputs: Path) -> set[str]:
    """Survey the store, and return the ids of its stale runs."""
    from repro.tracking.paths import Paths
    from repro.tracking.survey import survey

    return {item.id for item in survey(Paths(outputs)) if item.state == "stale"}
