"""Where the settings of all runs lie, and a digest that changes when any of them may have."""

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from repro.errors import UserError

SOURCE = Path(__file__).resolve().parents[1]
ROOT = SOURCE.parents[1]
CONF, EXPERIMENTS = ROOT / "conf", ROOT / "experiments"
READERS = ("config", "pipeline")  # rooms whose code makes stages of the settings
DECLARERS = ("plugins", "mechanics", "models", "data", "learning", "control")


def check_checkout() -> None:
    """UserError where the package was installed without the folders that it reads its settings from."""
    if not (CONF / "config.yaml").is_file():
        raise UserError(f"conf/ is not in {ROOT}: this needs the project's checkout (pip install -e . in its folder)")


def digest(experiment: str = "") -> str:
    """SHA-256 of conf/, an experiment's file and the code that makes stages of them; equal digests give equal stages.

    The options' defaults that models and optimisers declare are part of their code, which every stage names itself.
    """
    files = [
        *sorted(CONF.rglob("*.yaml")),
        *(path for room in READERS for path in sorted((SOURCE / room).rglob("*.py"))),
    ]
    if experiment and (EXPERIMENTS / f"{experiment}.yaml").is_file():
        files.append(EXPERIMENTS / f"{experiment}.yaml")
    return _summed(files)


@cache
def code_digest() -> str:
    """SHA-256 of the code that says which options models, optimisers and systems have, and what they accept."""
    files = [path for room in DECLARERS for path in sorted((SOURCE / room).rglob("*.py"))]
    return _summed(files)


def _summed(files: Iterable[Path]) -> str:
    summed = hashlib.sha256()
    for path in files:
        content = path.read_bytes()
        summed.update(f"{path.relative_to(ROOT)} {len(content)}\n".encode() + content)
    return summed.hexdigest()
