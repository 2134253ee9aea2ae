"""Which runs belong to which experiment: outputs/experiments/<scale>/<experiment>.json."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Self

from repro.errors import UserError
from repro.pipeline.card import card_of
from repro.results.results import Case
from repro.sweep.planned_job import PlannedJob
from repro.tracking.files import write_json


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

    @classmethod
    def of(cls, job: PlannedJob) -> Self:
        """The entry of a planned job."""
        known = (list(job.composed.overrides), job.run, job.composed.command)
        if job.record is not None:
            return cls(*known)
        card = card_of(job.pipeline.config)
        return cls(*known, dict(card.settings), sorted(card.changed))


@dataclass(frozen=True)
class ExperimentList:
    """All jobs of one experiment; `settings` is the digest of the settings that the ids of the runs follow from.

    `cases`, of sensitivity runs alone, say which run takes the place of which.
    """

    experiment: str
    scale: str
    settings: str
    jobs: Sequence[ListedJob] = ()
    cases: Sequence[Case] = ()

    @classmethod
    def read(cls, path: Path) -> Self | None:
        """The stored list, None where there is none. Raises UserError for a damaged file."""
        try:
            content = json.loads(path.read_bytes())
            jobs = [ListedJob(**job) for job in content.pop("jobs")]
            cases = [Case(**case) for case in content.pop("cases", ())]
            return cls(**content, jobs=jobs, cases=cases)
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            raise UserError(f"{path} cannot be read ({error}); delete it and run the experiment again") from error

    def write(self, path: Path) -> None:
        """Write the list, atomically."""
        content = asdict(self)
        if not self.cases:
            del content["cases"]
        write_json(path, content)
