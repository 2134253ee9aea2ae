"""The rows of a bench that was interrupted."""

import json
from pathlib import Path

from repro.bench.comparison import PairedComparison

FILE = "checkpoint.jsonl"  # a file of this name stays in the working folder of a stage until the stage is finished


class MeasuredRows:
    """Rows in a folder, one per line, written as soon as they are measured."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        lines = self.path.read_text().splitlines() if self.path.exists() else []
        self._rows = dict(entry for line in lines if (entry := _parsed(line)) is not None)

    def row(self, comparison: PairedComparison) -> dict[str, object]:
        """The row of a comparison: the stored one, or a new measurement."""
        key = f"{comparison.label}, {comparison.members}"
        if key not in self._rows:
            self._rows[key] = comparison.row(comparison.measure())
            with self.path.open("a") as file:
                file.write("\n" + json.dumps([key, self._rows[key]]))
        return self._rows[key]


def _parsed(line: str) -> tuple[str, dict[str, object]] | None:
    try:
        key, row = json.loads(line)
    except json.JSONDecodeError:  # empty, or cut off when the process was killed
        return None
    return key, row
