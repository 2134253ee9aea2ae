"""The state of the source tree: commit, and everything that differs from it as one patch."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from repro.tracking.files import write_bytes

_LARGEST_UNTRACKED_BYTES = 1_000_000


@cache
def source_tree() -> Path | None:
    """Top folder of the git checkout this package runs from; None for an installed copy or without git."""
    here = Path(__file__).resolve()
    if shutil.which("git") is None:
        return None
    try:
        _git(here.parent, "ls-files", "--error-unmatch", here.name)
        return Path(_text(here.parent, "rev-parse", "--show-toplevel").strip()).resolve()
    except (subprocess.CalledProcessError, OSError):
        return None


def state(patches: Path) -> dict[str, Any]:
    """Commit, branch, clean or not, and the patch (uncommitted changes and new files together) that `git apply` takes.

    The patch is stored once per content as <patches>/<hash>.patch. New files above 1 MB are named, not stored.
    """
    top = source_tree()
    if top is None:
        return {"commit": None, "why": "the package does not run from a git checkout"}
    try:
        return _state(top, patches)
    except subprocess.CalledProcessError as error:
        return {"commit": None, "why": f"git {error.cmd[3]} failed: {os.fsdecode(error.stderr).strip()}"}


def _state(top: Path, patches: Path) -> dict[str, Any]:
    status = _text(top, "status", "--porcelain=v2", "--branch", "--untracked-files=all", "-z").split("\0")
    header = dict(line[2:].split(" ", 1) for line in status if line.startswith("# "))
    untracked = [line[2:] for line in status if line.startswith("? ")]
    results = patches.parent.resolve()
    if results != top and results.is_relative_to(top):
        untracked = [name for name in untracked if not (top / name).is_relative_to(results)]
    modified = any(line and line[0] in "12u" for line in status)
    record: dict[str, Any] = {
        "commit": header.get("branch.oid"),
        "branch": header.get("branch.head"),
        "clean": not (modified or untracked),
        "patch": None,
    }
    if not record["clean"]:
        small = [name for name in untracked if (top / name).lstat().st_size <= _LARGEST_UNTRACKED_BYTES]
        patch = _patch(top, small)
        file = patches / f"{hashlib.sha256(patch).hexdigest()[:16]}.patch"
        if not file.exists():
            write_bytes(file, patch)
        record["patch"] = f"{patches.name}/{file.name}"
        record["untracked"] = small
        record["untracked_not_stored"] = sorted(set(untracked) - set(small))
    return record


def _patch(top: Path, new_files: list[str]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        # A copy of git's list of files, so that naming the new ones leaves the user's own list alone.
        index = Path(folder) / "index"
        shutil.copyfile(Path(_text(top, "rev-parse", "--path-format=absolute", "--git-path", "index").strip()), index)
        environment = {"GIT_INDEX_FILE": str(index)}
        if new_files:
            _git(top, "add", "--intent-to-add", "--", *new_files, environment=environment)
        return _git(top, "diff", "--binary", "--no-ext-diff", "HEAD", environment=environment)


def _text(folder: Path, *arguments: str) -> str:
    return os.fsdecode(_git(folder, *arguments))


def _git(folder: Path, *arguments: str, environment: dict[str, str] | None = None) -> bytes:
    # Without optional locks, git status cannot block a git command of the user.
    outcome = subprocess.run(
        ["git", "-C", str(folder), *arguments],
        check=True,
        capture_output=True,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "GIT_OPTIONAL_LOCKS": "0", "LC_ALL": "C", **(environment or {})},
    )
    return outcome.stdout
