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
    """Of one experiment ("": of single runs), by the overrides of a job.

    composed  what Hydra made under the settings of this digest
    accepted  the checked configurations, under this code of models, optimisers and systems as well
    """

    file: Path | None
    settings: str
    code: str
    composed: dict[str, dict[str, Any]] = field(default_factory=dict)
    accepted: dict[str, dict[str, Any]] = field(default_factory=dict)
    changed: bool = False

    @classmethod
    def of(cls, folder: Path | None, experiment: str) -> Self:
        """The cache in a folder, empty where the file does not fit; without a folder nothing is stored."""
        file = None if folder is None else folder / f"{experiment or 'single'}.json"
        cache = cls(file, digest(experiment), code_digest())
        if file is not None:
            # A file that is missing or damaged costs time, nothing else.
            with suppress(OSError, ValueError, KeyError, TypeError):
                stored = json.loads(file.read_bytes())
                if stored["settings"] == cache.settings:
                    cache.composed = stored["composed"]
                    cache.accepted = stored["accepted"] if stored["code"] == cache.code else {}
        return cache

    def raw(self, job: Sequence[str]) -> dict[str, Any] | None:
        """What Hydra made of a job, or None."""
        return self.composed.get(_key(job))

    def checked(self, job: Sequence[str]) -> Config | None:
        """The configuration of a job that was accepted before, or None."""
        content = self.accepted.get(_key(job))
        return None if content is None else Config.model_validate(content)

    def keep(self, job: Sequence[str], raw: dict[str, Any], config: Config) -> None:
        """Take a job that was composed and accepted; one that reads a file is checked each time, as the file is."""
        self.composed[_key(job)] = raw
        if isinstance(config.data, RandomForce):
            self.accepted[_key(job)] = config.model_dump(mode="json")
        self.changed = True

    def save(self) -> None:
        """Write what is new."""
        if self.file is None or not self.changed:
            return
        content = {name: getattr(self, name) for name in ("settings", "code", "composed", "accepted")}
        # A cache that cannot be written (read-only results) costs time, nothing else.
        with suppress(OSError):
            write_text(self.file, json.dumps(content))


def _key(job: Sequence[str]) -> str:
    return " ".join(job)
