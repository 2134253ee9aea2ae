"""The jobs that the experiments list: experiments/<scale>/<experiment>.json."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from repro.errors import UserError
from repro.tracking.paths import Paths


@dataclass(frozen=True)
class JobOfAList:
    """One job; `run` is empty until it has reached its run, `settings` the digest under which it was listed."""

    experiment: str
    scale: str
    settings: str
    run: str
    command: str
    overrides: Sequence[str]


def listed_jobs(paths: Paths) -> Iterator[JobOfAList]:
    """Every job of every list. Raises UserError naming a damaged file."""
    for file in sorted(paths.experiments.glob("*/[!.]*.json")):
        try:
            content = json.loads(file.read_bytes())
            place = content["experiment"], content["scale"], content.get("settings", "")
            jobs = [JobOfAList(*place, job["run"], job["command"], job["overrides"]) for job in content["jobs"]]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise UserError(f"{file} cannot be read ({error!r}): delete it and run the experiment again") from error
        yield from jobs
