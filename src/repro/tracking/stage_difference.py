"""How two stages differ: config, code, libraries, upstream, origin, results."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from repro.tracking.plain_data import flattened
from repro.tracking.record import Identity, Record
from repro.tracking.store import Store
from repro.tracking.text import short

_ORIGIN_KEYS = ("git.commit", "git.clean", "git.patch", "machine", "threads", "torch", "overrides", "command")


@dataclass(frozen=True)
class Difference:
    """One thing that differs; a side that lacks it is None.

    area  "config", "code", "libraries", "upstream", "origin" or "results", after the role of an upstream stage where it
          is not the stage itself ("fit: config")
    """

    area: str
    key: str
    before: Any
    after: Any

    def __str__(self) -> str:
        if self.area.endswith("code"):
            if self.before is None or self.after is None:
                return f"module {self.key} is {'reached now' if self.before is None else 'no longer reached'}"
            return f"module {self.key} changed"
        word = "library" if self.area == "libraries" else self.area
        return f"{word} {self.key}: {short(self.before)} -> {short(self.after)}"


def identity_differences(before: Identity, after: Identity) -> list[Difference]:
    """What differs between two identities, in the order config, upstream, code, libraries."""
    return [
        *_differences("config", flattened(before.config), flattened(after.config)),
        *_differences("upstream", before.upstream, after.upstream),
        *_differences("code", before.code, after.code),
        *_differences("libraries", before.libraries, after.libraries),
    ]


def record_differences(store: Store, before: Record, after: Record, role: str = "") -> list[Difference]:
    """Everything that differs between two stored stages, and below them between the stages they were made from."""
    prefix = f"{role}: " if role else ""
    differences = list(identity_differences(before.identity, after.identity))
    if not role:
        differences += _differences("origin", _origin(before), _origin(after))
        differences += _differences("results", flattened(before.summary), flattened(after.summary))
    differences = [Difference(prefix + one.area, one.key, one.before, one.after) for one in differences]
    for part, id_before in before.identity.upstream.items():
        id_after = after.identity.upstream.get(part)
        if id_after is not None and id_after != id_before:
            old, new = store.find(id_before), store.find(id_after)
            if old is not None and new is not None:
                differences += record_differences(store, old, new, role=f"{role}.{part}" if role else part)
    return differences


def _differences(area: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[Difference]:
    for key in [*before, *(key for key in after if key not in before)]:
        if before.get(key) != after.get(key):
            yield Difference(area, key, before.get(key), after.get(key))


def _origin(record: Record) -> dict[str, Any]:
    provenance = flattened(asdict(record.provenance))
    return {key: value for key, value in provenance.items() if key.startswith(_ORIGIN_KEYS)}
