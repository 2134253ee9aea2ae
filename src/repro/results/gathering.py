"""What a paper's folder says of its results: the protocols as printed, and whose motions are kept."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from repro.errors import UserError
from repro.results.as_printed import Protocols, load_protocols
from repro.tracking.yaml_file import read_yaml


@dataclass(frozen=True)
class Gathering:
    """How runs are gathered for one paper.

    protocols        what counts as printed
    trajectories_of  experiments whose trajectories are kept
    closed_loops_of  experiments of whose closed loops the first of each run is kept
    """

    protocols: Protocols = field(default_factory=dict)
    trajectories_of: tuple[str, ...] = ()
    closed_loops_of: tuple[str, ...] = ()

    @classmethod
    def load(cls, paper: Path) -> Self:
        """Read as_printed.yaml and motions.yaml of a paper, where they exist. Raises UserError for a damaged file."""
        path, printed = paper / "motions.yaml", paper / "as_printed.yaml"
        protocols = load_protocols(printed) if printed.is_file() else {}
        if not path.is_file():
            return cls(protocols)
        content = read_yaml(path)
        try:
            trajectories, closed_loops = (tuple(map(str, content[key])) for key in ("trajectories", "closed_loops"))
        except (KeyError, TypeError) as error:
            message = f"{path} must hold the lists `trajectories` and `closed_loops` of names of experiments: {error}"
            raise UserError(message) from error
        return cls(protocols, trajectories, closed_loops)


NO_PAPER = Gathering()
