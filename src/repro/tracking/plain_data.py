"""Plain data (numbers, text, lists, dictionaries): their one JSON text, and the digest that identifies a stage."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from repro.plugins.options import Options

Json = dict[str, Any]  # the content of a JSON object


def plain(value: Any) -> Any:
    """Numbers of numpy, tuples, sets, paths and options as plain JSON values; raises TypeError for anything else."""
    if isinstance(value, Options):
        return value.plain()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, set | frozenset):
        return sorted(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "items"):
        return dict(value)
    raise TypeError(f"{type(value).__name__} {value!r} is not plain data (numbers, text, lists, dictionaries)")


def plain_copy(value: Any) -> Any:
    """The value as it reads back from JSON."""
    return json.loads(json.dumps(value, default=plain))


def digest(value: Any) -> str:
    """SHA-256 of the one JSON text of a value (sorted keys, no blanks), in hexadecimal."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), default=plain)
    return hashlib.sha256(text.encode()).hexdigest()


def flattened(value: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested dictionaries as one, with dotted keys."""
    flat: dict[str, Any] = {}
    for key, item in value.items():
        if isinstance(item, Mapping) and item:
            flat.update(flattened(item, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = item
    return flat
