"""Where the settings of all runs lie, and a digest that changes when any of them may have."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from repro.errors import UserError
from repro.plugins.roots import PROJECT, SOURCE, plugin_roots
from repro.tracking import plain_data
from repro.tracking.files import file_digest

ROOT = PROJECT
CONF, EXPERIMENTS = ROOT / "conf", ROOT / "experiments"
READERS = ("config", "pipeline")  # rooms whose code makes stages of the settings
DECLARERS = ("plugins", "mechanics", "models", "data", "learning", "control", "evaluation")


def settings_roots() -> tuple[Path, ...]:
    """Folders that may hold conf/ and experiments/: the checkout, then the user's plugins."""
    return (ROOT, *plugin_roots())


def experiment_files() -> dict[str, Path]:
    """The file of every experiment by its name, sorted; the project's where a name is there twice."""
    files = [path for root in reversed(settings_roots()) for path in (root / EXPERIMENTS.name).glob("[!._]*.yaml")]
    return dict(sorted((path.stem, path) for path in files))


def option_file(group: str, option: str) -> Path:
    """The file of an option, the project's first."""
    places = [root / CONF.name / group / f"{option}.yaml" for root in settings_roots()]
    return next((path for path in places if path.is_file()), places[0])


def check_checkout() -> None:
    """UserError where the package was installed without the folders that it reads its settings from."""
    if not (CONF / "config.yaml").is_file():
        raise UserError(f"conf/ is not in {ROOT}: this needs the project's checkout (pip install -e . in its folder)")


def digest(experiment: str = "") -> str:
    """SHA-256 of conf/, an experiment's file and the code that makes stages of them; equal digests give equal stages.

    The options' defaults that models and optimisers declare are part of their code, which every stage names itself.
    """
    path = experiment_files().get(experiment)
    return plain_data.digest([*_shared(settings_roots()), *(_summed([path]) if path else ())])


@cache
def code_digest() -> str:
    """SHA-256 of the code that says which options models, optimisers and systems have, and what they accept."""
    folders = (SOURCE, *plugin_roots())
    files = [path for room in DECLARERS for folder in folders for path in sorted((folder / room).rglob("*.py"))]
    return plain_data.digest(_summed(files))


@cache  # as are the settings that a process has read
def _shared(roots: tuple[Path, ...]) -> list[tuple[Path, str]]:
    """What all experiments have in common."""
    settings = (path for root in roots for path in sorted((root / CONF.name).rglob("*.yaml")))
    return _summed([*settings, *(path for room in READERS for path in sorted((SOURCE / room).rglob("*.py")))])


def _summed(files: Iterable[Path]) -> list[tuple[Path, str]]:
    return [(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path, file_digest(path)) for path in files]
