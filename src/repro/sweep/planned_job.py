"""Jobs of a sweep before they run: what they will make, whether that is there already, and about how long it takes."""

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

from repro.config.compose import Composed, Overrides, plan
from repro.config.overrides import expand, experiments
from repro.data.data_options import RandomForce
from repro.pipeline.card import card_of
from repro.pipeline.plan import Pipeline
from repro.results.selectors import Where, agrees
from repro.results.table_schema import as_text
from repro.sweep.expected_cost import MeasuredStages, expected_mib, expected_seconds
from repro.tracking.paths import FAILED, Paths
from repro.tracking.record import Record
from repro.tracking.store import Store
from repro.tracking.text import duration

if TYPE_CHECKING:
    from repro.claims.claims import Claim

SAMPLED = "smoke"
LIKELY = 4  # jobs of an experiment that are composed at a time, in search of one that a selector means
BRIEFLY = 2  # jobs of an experiment that this scale leaves out


@dataclass(frozen=True)
class PlannedJob:
    """A job with its pipeline, and its record when it is finished already.

    `expected_seconds` orders the jobs and sharpens the time left, `expected_mib` limits how many run at once; both are
    0 for a finished job.
    """

    composed: Composed
    pipeline: Pipeline
    record: Record | None = None
    expected_seconds: float = 0.0
    expected_mib: float = 0.0

    @classmethod
    def of(cls, composed: Composed) -> Self:
        """The job of a checked configuration, without a look at what is stored."""
        return cls(composed, Pipeline.of(composed.config, composed.command))

    @property
    def run(self) -> str:
        """The id that its run has or will have."""
        return self.pipeline.run_stage.id

    @property
    def label(self) -> str:
        """A short name for progress lines."""
        return f"{self.pipeline.name} {self.run.rpartition('-')[2][:6]}"

    def answers(self, claim: "Claim") -> bool:
        """Whether a selector of the claim means its run, as far as the settings show before it is run."""
        return any(map(self.agrees, claim.selectors))

    def agrees(self, where: Where) -> bool:
        """Whether a selector means its run."""
        return agrees(lambda name: as_text(self._columns.get(name)), where)

    @cached_property
    def _columns(self) -> dict[str, object]:
        """The card that its run will have, or that of its closed loops where it has any, by column."""
        config, n_train = self.pipeline.config, None
        if isinstance(config.data, RandomForce):
            share = int(config.data.samples * config.data.train_fraction)
            n_train = min(share, config.data.train_samples or share)
        card = card_of(config)
        card = replace(card, measured={"n_train": n_train, "epochs": card.settings.get("optimiser.epochs", 0)})
        return {**card.settings, **card.run_columns(), **({} if config.control.kind == "none" else card.loop_columns())}

    def failures(self, store: Store) -> list[Record]:
        """Those of its stages whose last attempt failed."""
        stages = [*self.pipeline.stages, self.pipeline.recording_stage]
        last_attempts = (store.find(stage.id, kind=stage.kind, shelf=FAILED) for stage in stages)
        return [record for record in last_attempts if record is not None]


def plan_jobs(
    jobs: Sequence[Overrides],
    paths: Paths,
    on_unknown: Callable[[list[Overrides]], None] = lambda jobs: None,
) -> list[PlannedJob]:
    """Compose, check and look up the jobs (the overrides of each); UserError before anything runs.

    `on_unknown` takes the jobs that were not planned before, where there are any: there is likely something to run.
    """

    def begin(unknown: list[Overrides]) -> None:
        if sys.stderr.isatty():
            print(f"composing {len(unknown)} new job{'s' * (len(unknown) > 1)}", file=sys.stderr, flush=True)
        on_unknown(unknown)

    store, measured = Store(paths.root), MeasuredStages(paths)
    planned, made = [], measured.ids
    for composed in plan(jobs, paths.composed, begin):
        pipeline = Pipeline.of(composed.config, composed.command)
        record = pipeline.finished(store)
        costs = () if record else (expected_seconds(pipeline, measured, made), expected_mib(pipeline, measured))
        made |= {stage.id for stage in pipeline.stages}  # by this job, for all that follow
        planned.append(PlannedJob(composed, pipeline, record, *costs))
    return planned


def plan_sample(
    claims: "Sequence[Claim]", paths: Paths, on_unknown: Callable[[list[Overrides]], None]
) -> list[PlannedJob]:
    """A job for every option that the experiments choose first in a line, and one for each selector of their claims.

    Of an experiment that is reproduced at larger scales alone, the first jobs of its first lines.
    """
    included = experiments(SAMPLED)
    jobs: list[Overrides] = []
    chosen: set[str] = set()
    for job in (job for name in included for job in _jobs(name, first_of_line=True)):
        if not chosen.issuperset(job):
            jobs.append(job)
            chosen.update(job)
    brief = [job for name in experiments("paper") if name not in included for job in _jobs(name, True)[:BRIEFLY]]
    planned = plan_jobs([*jobs, *brief], paths, on_unknown)
    wanted: dict[str, list[Where]] = {}
    for claim in claims:
        if claim.experiment in included:
            wanted.setdefault(claim.experiment, []).extend(claim.selectors)
    answers = [job for name, selectors in wanted.items() for job in _answering(name, selectors, planned, paths)]
    return [*planned, *plan_jobs(answers, paths)]


def _answering(
    experiment: str, selectors: Sequence[Where], planned: Sequence[PlannedJob], paths: Paths
) -> list[Overrides]:
    """Jobs of an experiment that those selectors mean of which none is planned; the likely ones are composed first."""
    there = [job for job in planned if job.composed.config.experiment == experiment]
    left = [where for where in selectors if not any(job.agrees(where) for job in there)]
    jobs = _jobs(experiment) if left else []
    order = [
        sorted(jobs, key=lambda job: -sum(f"={value}" in " ".join(job) for value in where.values())) for where in left
    ]
    known: dict[Overrides, PlannedJob] = {}

    def compose(some: Iterable[Overrides]) -> None:
        new = [job for job in dict.fromkeys(some) if job not in known]
        known.update(zip(new, map(PlannedJob.of, plan(new, paths.composed)), strict=True))

    compose(job for each in order for job in each[:LIKELY])
    found: dict[Overrides, PlannedJob] = {}
    for where, each in zip(left, order, strict=True):
        if any(job.agrees(where) for job in found.values()):
            continue
        for first in range(0, len(each), LIKELY):
            some = each[first : first + LIKELY]
            compose(some)
            if agreeing := [job for job in some if known[job].agrees(where)]:
                found[agreeing[0]] = known[agreeing[0]]
                break
    return [*found]


def _jobs(experiment: str, first_of_line: bool = False) -> list[Overrides]:
    return expand([f"experiment={experiment}", f"scale={SAMPLED}"], first_of_line=first_of_line)


def total(jobs: Sequence[PlannedJob]) -> str:
    """How many jobs there are, how many are to be run, and about how long that takes."""
    missing = [job for job in jobs if job.record is None]
    left = duration(sum(job.expected_seconds for job in missing))
    return f"{len(jobs)} job{'s' * (len(jobs) != 1)}, {len(missing)} to run, about {left} of one core"
