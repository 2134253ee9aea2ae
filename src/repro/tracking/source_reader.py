"""Source files as this process loaded them: their digests and imports, through a cache on disk, and later edits.

Python runs what a file held when it was loaded, so a digest that is read later describes the running code only if the
file did not change in between. A job is forked from a server that has loaded modules before it; what the server has
recorded of them stays true for the job, whatever is edited meanwhile.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking import syntax
from repro.tracking.files import write_text
from repro.tracking.paths import source_cache
from repro.tracking.syntax import Source

# A file younger than this may change again within one tick of the clock of its file system.
_SETTLED_S = 2.0
_FORMAT = 2


@dataclass(frozen=True)
class _FileState:
    """A source file when it was read; `stamp` is its time of change in ns and its size, C files included."""

    path: Path
    stamp: tuple[int, int]
    source: Source


class SourceReader:
    """Reads source files of one process.

    started    since when modules have been loaded by this process itself
    inherited  module -> the latest start of the process that had loaded it before the fork
    recorded   module -> source of a module that is loaded, whatever its file holds by now
    unloaded   module -> what its file held when it was read, before it was loaded
    """

    def __init__(self, cache_file: Path) -> None:
        self.cache_file = cache_file
        self.started = time.time()
        self.inherited: dict[str, float] = {}
        self.recorded: dict[str, Source] = {}
        self.unloaded: dict[str, _FileState] = {}
        self._cached: dict[str, Any] | None = None
        self._changed = False

    def read(self, path: Path, module: str) -> Source:
        """Digest, imports and libraries of a module's file.

        Raises UserError for a syntax error, and for a file that was edited after this process loaded it.
        """
        if module in self.recorded:
            return self.recorded[module]
        stamp = _stamp(path)
        changed, now = stamp[0] / 1e9, time.time()
        if module in sys.modules and self.inherited.get(module, self.started) < changed <= now:
            raise _edited(path)
        key = f"{path} {module}"
        entry = self._cache().get(key)
        if entry is not None and tuple(entry["stamp"]) == stamp:
            source = Source(entry["digest"], tuple(entry["imports"]), tuple(entry["libraries"]))
        else:
            source = syntax.analyse(path, module)
            if now - changed > _SETTLED_S:
                self._cache()[key] = {"stamp": stamp, **asdict(source)}
                self._changed = True
        if module not in sys.modules:
            self.unloaded.setdefault(module, _FileState(path, stamp, source))
        return source

    def save(self) -> None:
        """Write what is new to the cache; files that no longer exist are dropped."""
        if not self._changed:
            return
        self._changed = False
        files = {key: entry for key, entry in self._cache().items() if Path(key.rpartition(" ")[0]).exists()}
        # A cache that cannot be written costs time, nothing else.
        with suppress(OSError):
            write_text(self.cache_file, json.dumps({"format": _FORMAT, "files": files}))

    def check_unchanged(self, modules: Iterable[str]) -> None:
        """Raise UserError for a module that was edited after it was read and before this process loaded it."""
        for module in modules:
            if module in sys.modules and module in self.unloaded:
                state = self.unloaded[module]
                if not state.path.exists():
                    raise _edited(state.path)
                if _stamp(state.path) != state.stamp and syntax.analyse(state.path, module) != state.source:
                    raise _edited(state.path)

    def record(self, files: Iterable[tuple[str, Path]]) -> None:
        """Record the loaded modules whose files have not changed since this process started, for jobs forked later."""
        for module, path in files:
            if _stamp(path)[0] / 1e9 <= self.started:
                self.recorded[module] = self.read(path, module)
        self.save()

    def begin_job(self) -> None:
        """Mark the fork of a job: what is loaded from here on is younger than what its parent had loaded."""
        self.inherited.update(dict.fromkeys(sys.modules, self.started))
        self.started = time.time()
        self.unloaded.clear()

    def _cache(self) -> dict[str, Any]:
        if self._cached is None:
            try:
                stored = json.loads(self.cache_file.read_bytes())
                self._cached = dict(stored["files"]) if stored["format"] == _FORMAT else {}
            except (OSError, ValueError, KeyError, TypeError):
                self._cached = {}
        return self._cached


def _stamp(path: Path) -> tuple[int, int]:
    files = [each.stat() for each in (path, *syntax.c_files(path))]
    return max(file.st_mtime_ns for file in files), sum(file.st_size for file in files)


def _edited(path: Path) -> UserError:
    return UserError(f"{path} was edited while this command was running: start the same command again")


READER = SourceReader(source_cache())
