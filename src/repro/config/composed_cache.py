"""Configurations that were composed and checked before: one file per experiment, which may be deleted at any time."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from repro.config.places import code_digest, digest
from repro.config.schema import Config
from repro.data.data_options import RandomForce
from repro.tracking.files import write_text


@dataclass
class Cache:
    """Of one experiment ("": of single runs), by the overrides of a job, under these settings and this code."""

    file: Path | None
    sources: str
    accepted: dict[str, dict[str, Any]] = field(default_factory=dict)
    changed: bool = False

    @classmethod
    def of(cls, folder: Path | None, experiment: str) -> Self:
        """The cache in a folder, empty where the file does not fit; without a folder nothing is stored."""
        file = None if folder is None else folder / f"{experiment or 'single'}.json"
        cache = cls(file, f"{digest(experiment)} {code_digest()}")
        if file is not None:
            # A file that is missing or damaged costs time, nothing else.
            with suppress(OSError, ValueError, KeyError, TypeError):
                stored = json.loads(file.read_bytes())
                cache.accepted = stored["accepted"] if stored["sources"] == cache.sources else {}
        return cache

    def checked(self, job: Sequence[str]) -> Config | None:
        """The configuration of a job that was accepted before, or None."""
        content = self.accepted.get(" ".join(job))
        return None if content is None else Config.model_validate(content)

    def keep(self, job: Sequence[str], config: Config) -> None:
        """Take a job that was accepted; one that reads a file is checked each time, as the file is."""
        if isinstance(config.data, RandomForce):
            self.accepted[" ".join(job)] = config.model_dump(mode="json")
            self.changed = True

    def save(self) -> None:
        """Write what is new."""
        if self.file is not None and self.changed:
            # A cache that cannot be written (read-only results) costs time, nothing else.
            with suppress(OSError):
                write_text(self.file, json.dumps({"sources": self.sources, "accepted": self.accepted}))
