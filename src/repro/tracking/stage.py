"""What makes a stage the stage it is, and therefore when its result may be used again."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from repro.tracking import code
from repro.tracking.plain_data import digest, plain_copy

ID_DIGITS = 10


@dataclass(frozen=True)
class Stage:
    """One content-addressed step: equal identities give equal results, so a finished one is never repeated.

    kind     name of its folder in the store ("data", "fits", "runs", ...)
    name     readable label; part of the id, not of the identity
    config   resolved plain configuration of this stage alone
    upstream role -> id of each stage whose result it reads
    modules  full dotted names of the modules where its code starts, and of those it loads by a computed name
    command  the command line that makes it again
    ignore   dotted config keys that cannot matter to the result (e.g. "record.stride")
    """

    kind: str
    name: str
    config: Mapping[str, Any]
    upstream: Mapping[str, str]
    modules: tuple[str, ...]
    command: str = ""
    ignore: tuple[str, ...] = field(default=())

    @cached_property
    def identity(self) -> dict[str, Any]:
        """Everything the result depends on, as plain data: config, upstream, code, libraries, modules."""
        reached = code.closure(self.modules)
        identity: dict[str, Any] = {
            "config": _without(self.config, self.ignore),
            "upstream": dict(self.upstream),
            "code": reached.modules,
            "libraries": reached.libraries,
            "modules": sorted(self.modules),
        }
        return dict(plain_copy(identity))

    @cached_property
    def id(self) -> str:
        """Readable name, a dash, ten hexadecimal digits of the identity, e.g. sip-lagrangian-t2-adam-9f3c2a81bd."""
        readable = re.sub(r"[^a-z0-9]+", "-", self.name.lower()).strip("-")
        return f"{readable or self.kind}-{identity_digest(self.kind, self.identity)[:ID_DIGITS]}"


def identity_digest(kind: str, identity: Mapping[str, Any]) -> str:
    """SHA-256 of a kind and an identity, as stored in run.json."""
    return digest([kind, identity])


def _without(config: Mapping[str, Any], ignored: tuple[str, ...], prefix: str = "") -> dict[str, Any]:
    kept: dict[str, Any] = {}
    for key, value in config.items():
        path = f"{prefix}{key}"
        if path not in ignored:
            kept[key] = _without(value, ignored, f"{path}.") if isinstance(value, Mapping) else value
    return kept
