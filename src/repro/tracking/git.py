"""The state of the source tree: commit, and everything that differs from it as one patch."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from repro.tracking.files import file_digest, write_bytes

# The files that a run's identity is made from: of new files these alone are stored.
_READ_BY_RUNS = re.compile(r"src/repro/.*\.(py|c|h)|(conf|experiments)/.*\.yaml")
_LARGEST_DIGESTED_BYTES = 100_000_000


@cache
def source_tree() -> Path | None:
    """Top folder of the git checkout this package runs from; None for an installed copy or without git."""
    here = Path(__file__).resolve()
    try:
        _git(here.parent, "ls-files", "--error-unmatch", here.name)
        return Path(_git(here.parent, "rev-parse", "--show-toplevel").strip()).resolve()
    except (subprocess.CalledProcessError, OSError):
        return None


def state(patches: Path) -> dict[str, Any]:
    """Commit, branch, clean or not, and the patch (uncommitted changes and new source files) that `git apply` takes.

    The patch is stored once per content as <patches>/<hash>.patch. Of new files that no run is made from (data, .env)
    the name and the digest are stored, never the content.
    """
    top = source_tree()
    if top is None:
        return {"commit": None, "why": "the package does not run from a git checkout"}
    try:
        status = _git(top, "status", "--porcelain=v2", "--branch", "--untracked-files=all", "-z").split("\0")
        header = dict(line[2:].split(" ", 1) for line in status if line.startswith("# "))
        untracked = [line[2:] for line in status if line.startswith("? ")]
        if top in (results := patches.parent.resolve()).parents:
            untracked = [name for name in untracked if not (top / name).is_relative_to(results)]
        clean = not untracked and not any(line and line[0] in "12u" for line in status)
        record = {
            "commit": header.get("branch.oid"),
            "branch": header.get("branch.head"),
            "clean": clean,
            "patch": None,
        }
        if clean:
            return record
        source = [name for name in untracked if _READ_BY_RUNS.fullmatch(name)]
        patch = os.fsencode(_patch(top, source))
    except subprocess.CalledProcessError as error:
        return {"commit": None, "why": f"git {error.cmd[3]} failed: {os.fsdecode(error.stderr).strip()}"}
    file = patches / f"{hashlib.sha256(patch).hexdigest()[:16]}.patch"
    if not file.exists():
        write_bytes(file, patch)
    return record | {
        "patch": f"{patches.name}/{file.name}",
        "untracked": source,
        "untracked_not_stored": {name: _digest(top / name) for name in sorted(set(untracked) - set(source))},
    }


def _digest(path: Path) -> str | None:
    """SHA-256 of a file; None for one that is very large, a link, or cannot be read."""
    try:
        whole = path.is_file() and not path.is_symlink() and path.stat().st_size <= _LARGEST_DIGESTED_BYTES
        return file_digest(path) if whole else None
    except OSError:
        return None


def _patch(top: Path, new_files: list[str]) -> str:
    with tempfile.TemporaryDirectory() as folder:
        # A copy of git's list of files, so that naming the new ones leaves the user's own list alone.
        index = Path(folder) / "index"
        shutil.copyfile(Path(_git(top, "rev-parse", "--path-format=absolute", "--git-path", "index").strip()), index)
        environment = {"GIT_INDEX_FILE": str(index)}
        if new_files:
            _git(top, "add", "--intent-to-add", "--", *new_files, environment=environment)
        return _git(top, "diff", "--binary", "--no-ext-diff", "HEAD", environment=environment)


def _git(folder: Path, *arguments: str, environment: dict[str, str] | None = None) -> str:
    # Without optional locks, git status cannot block a git command of the user.
    outcome = subprocess.run(
        ["git", "-C", str(folder), *arguments],
        check=True,
        capture_output=True,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "GIT_OPTIONAL_LOCKS": "0", "LC_ALL": "C", **(environment or {})},
    )
    return os.fsdecode(outcome.stdout)
