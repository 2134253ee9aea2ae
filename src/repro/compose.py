"""From overrides to checked configurations, by Hydra; what was composed before is read from a file."""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.config import Config, parse
from repro.errors import UserError
from repro.overrides import CONF, EXPERIMENTS, ROOT, check, expand, first_lines, renamed

NEEDS_QUOTES = set("[]{}() $*;&|")


@dataclass(frozen=True)
class Composed:
    """One job of a sweep: its overrides, and the configuration that they make."""

    overrides: tuple[str, ...]
    config: Config

    @property
    def command(self) -> str:
        """The command line that repeats it."""
        shown = (override.replace("+experiments@_global_=", "+experiment=") for override in self.overrides)
        return " ".join(["repro run", *(f"'{o}'" if set(o) & NEEDS_QUOTES else o for o in shown)])


def plan(overrides: Sequence[str], *, paired: bool = False, cache: Path | None = None) -> list[Composed]:
    """All jobs of a sweep, composed and checked before any of them runs; UserError for the first that is wrong.

    cache: a file that keeps what Hydra composed, so that a known job costs nothing.
    """
    jobs = expand(overrides, paired)
    known = _load(cache)
    before = len(known)
    raw = {job: known.get(" ".join(job)) or _composed(job) for job in jobs}
    known |= {" ".join(job): content for job, content in raw.items()}
    if cache is not None and len(known) > before:
        _keep(cache, known)
    return [Composed(job, parse(content)) for job, content in raw.items()]


def compose(overrides: Sequence[str]) -> Composed:
    """One configuration; UserError names key, value and what is allowed."""
    overrides = tuple(renamed(override) for override in overrides)
    return Composed(overrides, parse(_composed(overrides)))


def _composed(overrides: Sequence[str]) -> dict[str, Any]:
    import hydra
    from hydra.core.global_hydra import GlobalHydra
    from hydra.errors import HydraException
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException

    check(overrides)
    try:
        if not GlobalHydra.instance().is_initialized():
            hydra.initialize_config_dir(str(CONF), version_base="1.3")
        composed = hydra.compose("config", [f"hydra.searchpath=[file://{ROOT}]", *overrides])
        resolved = OmegaConf.to_container(composed, resolve=True, throw_on_missing=False)
    except (HydraException, OmegaConfBaseException) as error:
        raise UserError(first_lines(error)) from None
    return {str(key): value for key, value in resolved.items() if key != "hydra"}


def _load(cache: Path | None) -> dict[str, Any]:
    try:
        stored = json.loads(cache.read_text()) if cache is not None else {}
    except (OSError, ValueError):
        return {}
    return stored.get("jobs", {}) if stored.get("fingerprint") == _fingerprint() else {}


def _keep(cache: Path, jobs: Mapping[str, Any]) -> None:
    cache.parent.mkdir(parents=True, exist_ok=True)
    temporary = cache.with_suffix(f".{os.getpid()}.tmp")
    temporary.write_text(json.dumps({"fingerprint": _fingerprint(), "jobs": jobs}))
    temporary.replace(cache)


def _fingerprint() -> str:
    """Digest of all that composition reads."""
    digest = hashlib.sha256()
    for path in [*sorted(CONF.rglob("*.yaml")), *sorted(EXPERIMENTS.glob("*.yaml")), Path(__file__)]:
        digest.update(f"{path.relative_to(ROOT)}\n".encode() + path.read_bytes())
    return digest.hexdigest()
