"""The file names of the store, all in one place."""

import os
import tempfile
from pathlib import Path

from repro.errors import UserError
from repro.plugins.roots import PROJECT, plugin_roots

RUN_FILE = "run.json"
HOLDER_FILE = "holder.json"
TEMPORARY_SUFFIX = ".tmp"
CHECKPOINT_PREFIX = "checkpoint"
ROOT_VARIABLE = "REPRO_OUTPUTS"
# Beside the finished stages of a kind: those being made (they survive a kill), the last failed attempts, damaged ones.
WORK, FAILED, DAMAGED = ".work", ".failed", ".damaged"
# Folders under the root that hold no finished stages.
NOT_KINDS = frozenset({"experiments", "report", "logs", "patches"})


def outputs_root() -> Path:
    """The folder of all results: $REPRO_OUTPUTS, else ./outputs; UserError when it cannot be a folder."""
    given = os.environ.get(ROOT_VARIABLE) or "outputs"
    root = Path(os.path.expanduser(given)).absolute()  # noqa: PTH111 - leaves ~ as it is where there is no home
    for place in (root, *root.parents):
        if place.exists() and not place.is_dir():
            raise UserError(f"{ROOT_VARIABLE}={root}: {place} is a file, not a folder; choose another folder")
    return root


class Paths:
    """Names of every file and folder under one outputs root; none is created here.

    experiments  folder of the job lists: experiments/<scale>/<experiment>.json
    logs         folder of the jobs' printed output
    index        the index of all run.json files; a cache, safe to delete
    composed     folder of the configurations composed so far, safe to delete
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self.experiments, self.logs = root / "experiments", root / "logs"
        self.index, self.composed = root / ".cache" / "index.sqlite", root / ".cache" / "composed"

    def folder(self, kind: str, id: str, shelf: str = "") -> Path:
        """Folder of a stage: finished, or on the shelf WORK, FAILED or DAMAGED."""
        return self.root / kind / shelf / id

    def lock(self, kind: str, id: str) -> Path:
        """Lock file of a stage; held by the operating system, never deleted by a run."""
        return self.root / kind / ".lock" / f"{id}.lock"

    def kinds(self) -> list[str]:
        """The kinds that have a folder, sorted."""
        return [name for name in _folders(self.root) if name not in NOT_KINDS]

    def ids(self, kind: str, shelf: str = "") -> list[str]:
        """Names of the folders of one kind on a shelf, sorted: the ids of the finished stages by default."""
        return _folders(self.root / kind / shelf)


def _folders(place: Path) -> list[str]:
    entries = os.scandir(place) if place.is_dir() else ()
    return sorted(entry.name for entry in entries if entry.is_dir() and not entry.name.startswith("."))


def source_cache() -> Path:
    """The user's cache of source digests, which no results folder needs to hold; safe to delete."""
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")  # noqa: PTH111 - raises nothing
    if home.startswith("~"):  # a user without an entry in the list of users, as in containers
        home = tempfile.gettempdir()
    return Path(home) / "repro" / "code.sqlite"


def project_folder() -> Path:
    """The folder that holds paper/: the first one of the user's plugins that has one, else that of this project.

    UserError where there is none.
    """
    places = [place for place in (*plugin_roots(), PROJECT) if (place / "paper" / "claims.yaml").is_file()]
    if not places:
        message = f"paper/claims.yaml is not in {PROJECT}: the report needs the project's checkout (pip install -e .)"
        raise UserError(message)
    return places[0]
