"""A checkpoint in the working folder of a stage, written every so often, whole or not at all."""

import time
from pathlib import Path

from repro.codegen.lazy_torch import torch
from repro.tracking.files import replacing

PAUSE_SECONDS = 10.0


class FileCheckpoint:
    """Keeps a fit's state in `folder`, so that it resumes after a kill or Ctrl-C."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "checkpoint.pt"
        self.last = time.monotonic()

    def load(self) -> object | None:
        """The last whole state, or None."""
        if not self.path.exists():
            return None
        state: object = torch.load(self.path, weights_only=False)
        return state

    def save(self, state: object) -> None:
        """Write the state if the last time is long enough ago."""
        if time.monotonic() - self.last < PAUSE_SECONDS:
            return
        with replacing(self.path) as temporary, temporary.open("wb") as file:
            torch.save(state, file)
        self.last = time.monotonic()
