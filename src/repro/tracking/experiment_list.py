"""Which runs belong to which experiment: experiments/<scale>/<experiment>.json."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Self

from repro.errors import UserError
from repro.tracking.files import write_json
from repro.tracking.paths import Paths


@dataclass(frozen=True)
class ListedJob:
    """One job of an experiment: its overrides, the id of its run, and the command line that repeats it.

    `settings` and `changed`, as on the run card, describe a run that was not finished when it was listed.
    """

    overrides: Sequence[str]
    run: str
    command: str
    settings: Mapping[str, object] = field(default_factory=dict)
    changed: Sequence[str] = field(default_factory=list)


@dataclass(frozen=True)
class Case:
    """One run that takes the place of ours for one claim; `choice` and `alternative` are spelt as overrides."""

    assumption: str
    choice: str
    alternative: str
    claim: str
    experiment: str
    run: str
    instead: str


@dataclass(frozen=True)
class ExperimentList:
    """All jobs of one experiment; `settings` is the digest of the settings that the ids of the runs follow from.

    `cases`, of sensitivity runs alone, say which run takes the place of which.
    """

    experiment: str
    scale: str
    settings: str = ""
    jobs: Sequence[ListedJob] = ()
    cases: Sequence[Case] = ()

    @classmethod
    def read(cls, path: Path) -> Self:
        """The list in a file. Raises UserError where it cannot be read."""
        try:
            content = json.loads(path.read_bytes())
            jobs = [ListedJob(**job) for job in content.pop("jobs")]
            cases = [Case(**case) for case in content.pop("cases", ())]
            return cls(**content, jobs=jobs, cases=cases)
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            raise UserError(f"{path} cannot be read ({error!r}); delete it and run the experiment again") from error

    def write(self, path: Path) -> None:
        """Write the list, atomically."""
        write_json(path, asdict(self))


def experiment_lists(paths: Paths, scale: str = "*") -> Iterator[ExperimentList]:
    """The lists of a scale, or of all. Raises UserError naming a damaged file."""
    for path in sorted(paths.experiments.glob(f"{scale}/[!.]*.json")):
        yield ExperimentList.read(path)
