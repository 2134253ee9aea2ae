"""Which runs are older than the code that would make them now, as the store judges."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from repro.results.stored import Staleness


def judged_by_tracking(outputs: Path) -> Staleness:
    """Survey the store once and answer for each of its runs."""
    from repro.tracking.paths import Paths
    from repro.tracking.survey import survey

    stale = {item.id for item in survey(Paths(outputs)) if item.state == "stale"}

    def is_stale(record: Mapping[str, Any]) -> bool:
        return record.get("id") in stale

    return is_stale
