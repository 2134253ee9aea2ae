"""The rows of a bench that was interrupted."""

import json
from pathlib import Path

from repro.bench.comparison import Comparison

FILE = "checkpoint.jsonl"  # the working folder of a stage keeps what is named so until the stage is finished


class KeptRows:
    """Rows in a folder, a line each, written as soon as they are measured."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        lines = self.path.read_text().splitlines() if self.path.exists() else []
        self._rows = dict(entry for line in lines if (entry := _parsed(line)) is not None)

    def row(self, comparison: Comparison) -> dict[str, object]:
        """The row of a comparison: found, or measured and kept."""
        key = f"{comparison.label}, {comparison.members}"
        if key not in self._rows:
            self._rows[key] = comparison.row(comparison.measure())
            with self.path.open("a") as file:
                file.write("\n" + json.dumps([key, self._rows[key]]))
        return self._rows[key]


def _parsed(line: str) -> tuple[str, dict[str, object]] | None:
    try:
        key, row = json.loads(line)
    except json.JSONDecodeError:  # nothing, or the process was killed while it wrote
        return None
    return key, row
