"""What a paper's folder says of its results: the protocols as printed, and whose motions are kept."""

from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from typing import Any, Self

from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as checked

from repro.errors import UserError
from repro.results.columns import Settings
from repro.tracking.files import read_yaml

FILES = ("as_printed.yaml", "motions.yaml")


@checked(frozen=True)
class Gathering:
    """How runs are gathered for one paper.

    protocols     what counts as printed: name -> dotted key -> value
    trajectories  experiments whose trajectories are kept, and the settings of these runs by dotted key
    closed_loops  experiments of whose closed loops the first of each run is kept
    """

    protocols: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    trajectories: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    closed_loops: tuple[str, ...] = ()

    @classmethod
    def load(cls, paper: Path) -> Self:
        """Read as_printed.yaml and motions.yaml of a paper, where they exist. Raises UserError for a damaged file."""
        content: dict[str, Any] = {}
        try:
            for name in FILES:
                content |= read_yaml(paper / name) if (paper / name).is_file() else {}
            return TypeAdapter(cls).validate_python(content)
        except (TypeError, ValueError, ValidationError) as error:
            message = f"{' and '.join(FILES)} in {paper} must hold mappings and lists of names: {error}"
            raise UserError(message) from error

    def is_as_printed(self, settings: Settings) -> bool:
        """Whether a run of these settings, at its scale, follows a protocol; what that does not name is free."""
        return any(_has(settings, printed) for printed in self.protocols.values())

    def keeps_trajectories(self, experiment: str, settings: Settings) -> bool:
        """Whether the trajectories of a run are kept."""
        return experiment in self.trajectories and _has(settings, self.trajectories[experiment])


def _has(settings: Settings, wanted: Mapping[str, Any]) -> bool:
    missing = object()
    return all(settings.get(key, missing) == value for key, value in wanted.items())


NO_PAPER = Gathering()
