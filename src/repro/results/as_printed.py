"""Which runs are what the paper prints: their settings agree with one of its protocols."""

from collections.abc import Mapping
from pathlib import Path

from repro.errors import UserError
from repro.results.columns import Settings
from repro.tracking.yaml_file import read_yaml

# Name -> dotted key -> value.
Protocols = Mapping[str, Settings]


def load_protocols(path: Path) -> Protocols:
    """Read paper/as_printed.yaml. Raises UserError when it cannot be read or holds something else."""
    content = read_yaml(path)
    try:
        stored = content["protocols"].items()
        return {str(name): {str(key): value for key, value in printed.items()} for name, printed in stored}
    except (KeyError, TypeError, AttributeError) as error:
        message = f"{path} must hold `protocols`, each a mapping of dotted keys of the configuration to values: {error}"
        raise UserError(message) from error


def is_as_printed(settings: Settings, protocols: Protocols) -> bool:
    """Whether a run of these settings, at its scale, follows a protocol; settings that it does not name are free."""
    missing = object()
    return any(
        all(settings.get(key, missing) == value for key, value in printed.items()) for printed in protocols.values()
    )
