"""The identity of a stage, which decides whether a stored result may be used again."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from repro.plugins.options import Options
from repro.tracking import code
from repro.tracking.plain_data import digest, plain_copy
from repro.tracking.record import Identity

ID_DIGITS = 10


@dataclass(frozen=True)
class Stage:
    """One content-addressed step: equal identities give equal results, so a finished one is never repeated.

    kind     name of its folder in the store ("data", "fits", "runs", ...)
    name     readable label; part of the id, not of the identity
    config   resolved configuration of this stage alone, plain or as typed options: all that its work is handed beside
             the stages upstream
    upstream role -> id of each stage whose result it reads
    modules  full dotted names of the modules where its code starts, and of those it loads by a computed name
    command  the command line that makes it again
    """

    kind: str
    name: str
    config: Mapping[str, Any] | Options
    upstream: Mapping[str, str]
    modules: tuple[str, ...]
    command: str = ""

    @cached_property
    def identity(self) -> Identity:
        """Everything the result depends on."""
        return replace(code.closure(self.modules), config=plain_copy(self.config), upstream=dict(self.upstream))

    @cached_property
    def id(self) -> str:
        """Readable name, a dash, ten hexadecimal digits of the identity, e.g. sip-lagrangian-t2-adam-9f3c2a81bd."""
        readable = re.sub(r"[^a-z0-9]+", "-", self.name.lower()).strip("-")
        return f"{readable or self.kind}-{digest([self.kind, vars(self.identity)])[:ID_DIGITS]}"
