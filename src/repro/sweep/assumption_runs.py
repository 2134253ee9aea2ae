"""The runs that show which verdicts an assumption moves: each assumption changed by itself, on few members."""

import itertools
import operator
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass

from repro.claims.assumption_effects import METRIC
from repro.claims.assumptions import Assumption, Trial
from repro.claims.claims import Claim
from repro.config.overrides import expand, key_of
from repro.config.places import digest
from repro.errors import UserError
from repro.results.results import SENSITIVITY
from repro.sweep.listing import listed_job
from repro.sweep.planned_job import PlannedJob, plan_jobs
from repro.tracking.experiment_list import Case, ExperimentList, experiment_lists
from repro.tracking.files import disk_errors_explained
from repro.tracking.paths import Paths

SCALE, MEMBERS = "quick", 3


@dataclass(frozen=True)
class TriedClaim:
    """One claim under one trial of an assumption: the jobs that answer it by our choice."""

    assumption: Assumption
    trial: Trial
    claim: Claim
    jobs: tuple[PlannedJob, ...]


def plan_cases(
    ledger: Sequence[Assumption], claims: Sequence[Claim], paths: Paths
) -> tuple[list[Case], list[PlannedJob]]:
    """Every case of these assumptions, and the jobs that they need, each once.

    UserError before anything runs, also for an alternative that changes no run of a claim, so shows nothing about it.
    """
    tried = [*_tried_claims(ledger, {claim.name: claim for claim in claims}, paths)]
    pairs = [(each, alternative, ours) for each in tried for alternative in each.trial.instead for ours in each.jobs]
    others = plan_jobs([_substitute(ours, alternative) for _, alternative, ours in pairs], paths)
    cases = [
        Case(
            assumption=each.assumption.id,
            choice=_choice(ours, alternative),
            alternative=alternative,
            claim=each.claim.name,
            experiment=each.claim.experiment,
            run=ours.run,
            instead=other.run,
        )
        for (each, alternative, ours), other in zip(pairs, others, strict=True)
    ]
    effect = operator.attrgetter("assumption", "alternative", "claim")
    for (assumption, alternative, claim), own in itertools.groupby(sorted(cases, key=effect), key=effect):
        if not alternative.startswith(METRIC) and all(case.run == case.instead for case in own):
            raise UserError(f"assumptions.yaml, {assumption}: {alternative} changes no run that answers {claim}")
    needed = [*(job for each in tried for job in each.jobs), *others]
    return cases, [*{job.run: job for job in needed}.values()]


def list_cases(paths: Paths, cases: Sequence[Case], jobs: Sequence[PlannedJob], tried: Set[str]) -> None:
    """Write the cases and their jobs where the report looks for them: experiments/sensitivity/<experiment>.json.

    What was listed before for assumptions that are not `tried` now stays. Raises UserError for a damaged list.
    """
    folder, listed = paths.experiments / SENSITIVITY, [*experiment_lists(paths, SENSITIVITY)]
    retained = [case for each in listed for case in each.cases if case.assumption not in tried]
    known = {job.run: job for each in listed for job in each.jobs} | {job.run: listed_job(job) for job in jobs}
    by_experiment: dict[str, list[Case]] = {}
    for case in [*retained, *cases]:
        by_experiment.setdefault(case.experiment, []).append(case)
    with disk_errors_explained(paths.root):
        for experiment, own in by_experiment.items():
            runs = dict.fromkeys(run for case in own for run in (case.run, case.instead))
            entries = [known[run] for run in runs]
            ExperimentList(experiment, SENSITIVITY, digest(experiment), entries, own).write(
                folder / f"{experiment}.json"
            )
        for path in folder.glob("*.json"):
            if path.stem not in by_experiment:
                path.unlink()


def _tried_claims(ledger: Sequence[Assumption], claims: Mapping[str, Claim], paths: Paths) -> Iterator[TriedClaim]:
    named = [(row, trial, name) for row in ledger for trial in row.trials for name in trial.claims]
    for row, _, name in named:
        if name not in claims:
            raise UserError(f"assumptions.yaml, {row.id}: no claim is called {name}; there are {', '.join(claims)}")
    tried = [(row, trial, claims[name]) for row, trial, name in named]
    overrides = {(claim.experiment, trial.both): _jobs(claim.experiment, trial.both) for _, trial, claim in tried}
    # All jobs are planned in one go, which is faster, and then dealt out to their groups.
    planned = iter(plan_jobs([job for jobs in overrides.values() for job in jobs], paths))
    jobs_of = {group: [next(planned) for _ in jobs] for group, jobs in overrides.items()}
    for row, trial, claim in tried:
        answers = [
            job
            for job in jobs_of[claim.experiment, trial.both]
            if job.answers(claim) and (not trial.only or trial.only in job.composed.overrides)
        ]
        if not answers:
            raise UserError(f"assumptions.yaml, {row.id}: no job of {claim.experiment} answers {claim.name}")
        yield TriedClaim(row, trial, claim, tuple(answers))


def _jobs(experiment: str, both: str) -> list[tuple[str, ...]]:
    own = both.split()
    members = [] if any(override.startswith("seeds=") for override in own) else [f"seeds={MEMBERS}"]
    return expand([f"experiment={experiment}", f"scale={SCALE}", "record=false", *members, *own])


def _substitute(ours: PlannedJob, alternative: str) -> tuple[str, ...]:
    """The overrides of the job that takes our job's place; our own where the alternative does not concern it."""
    own = [override for override in alternative.split() if not override.startswith(METRIC)]
    changed = [override for override in own if _value(ours, key_of(override)) is not _ABSENT]
    keys = {key_of(override) for override in changed}
    # In front, where the lines of the experiment stand: the scale cuts them alike.
    return (*changed, *(override for override in ours.composed.overrides if key_of(override) not in keys))


_ABSENT = object()


def _value(job: PlannedJob, key: str) -> object:
    """The value of a dotted key in the configuration of a job."""
    section: object = job.composed.config.model_dump(mode="json")
    for part in key.split("."):
        if not isinstance(section, dict) or part not in section:
            return _ABSENT
        section = section[part]
    return section


def _choice(ours: PlannedJob, alternative: str) -> str:
    """What our job has where the alternative has something else, as overrides."""
    overrides = []
    for key in map(key_of, alternative.split()):
        value = _value(ours, key)
        if isinstance(value, dict):  # a whole group, which is written by the name of its option
            value = value.get("regime") or value.get("reading") or value.get("name") or value.get("kind")
        if value is not _ABSENT:
            overrides.append(f"{key}={str(value).lower() if value is None or isinstance(value, bool) else value}")
    return " ".join(overrides)
