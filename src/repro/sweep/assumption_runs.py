"""`repro sensitivity`: each assumption changed by itself, on few members, to see which verdicts it moves."""

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import asdict, dataclass
from typing import Any

from repro.claims.assumptions import Assumption, Trial
from repro.claims.claims import Claim
from repro.config.overrides import expand
from repro.config.places import digest
from repro.errors import UserError
from repro.results.results import SENSITIVITY, Case
from repro.results.stored import read_json
from repro.sweep.planned_job import Planned, planned
from repro.sweep.relevant_jobs import answering
from repro.tracking.files import disk_errors_explained, write_json
from repro.tracking.paths import Paths

SCALE, MEMBERS = "quick", 3


@dataclass(frozen=True)
class Question:
    """One claim under one trial of an assumption: the jobs that answer it by our choice."""

    assumption: Assumption
    trial: Trial
    claim: Claim
    jobs: tuple[Planned, ...]


def plan_cases(ledger: Sequence[Assumption], claims: Sequence[Claim], paths: Paths) -> tuple[list[Case], list[Planned]]:
    """Every case of these assumptions, and the jobs that they need, each once; UserError before anything runs."""
    questions = [*_questions(ledger, {claim.name: claim for claim in claims}, paths)]
    pairs = [
        (question, alternative, ours, _instead(ours, alternative))
        for question in questions
        for alternative in question.trial.instead
        for ours in question.jobs
    ]
    others = planned([overrides for *_, overrides in pairs], paths)
    cases = [
        Case(
            assumption=question.assumption.id,
            choice=_choice(ours, alternative),
            alternative=alternative,
            claim=question.claim.name,
            experiment=question.claim.experiment,
            run=ours.run,
            instead=other.run,
        )
        for (question, alternative, ours, _), other in zip(pairs, others, strict=True)
    ]
    _refuse_idle(cases)
    needed = [*(job for question in questions for job in question.jobs), *others]
    return cases, [*{job.run: job for job in needed}.values()]


def list_cases(paths: Paths, cases: Sequence[Case], jobs: Sequence[Planned], tried: Set[str]) -> None:
    """Write the cases and their jobs where the report looks for them: experiments/sensitivity/<experiment>.json.

    What was listed before for assumptions that are not `tried` now stays.
    """
    folder = paths.experiments / SENSITIVITY
    listed = [read_json(path) for path in sorted(folder.glob("*.json"))]
    kept = [case for each in listed for case in each["cases"] if case["assumption"] not in tried]
    known = {job["run"]: job for each in listed for job in each["jobs"]} | {job.run: _entry(job) for job in jobs}
    by_experiment: dict[str, list[dict[str, str]]] = {}
    for case in [*kept, *map(asdict, cases)]:
        by_experiment.setdefault(case["experiment"], []).append(case)
    with disk_errors_explained(paths.root):
        for experiment, own in by_experiment.items():
            runs = dict.fromkeys(run for case in own for run in (case["run"], case["instead"]))
            content: dict[str, Any] = {"experiment": experiment, "scale": SENSITIVITY, "settings": digest(experiment)}
            write_json(folder / f"{experiment}.json", content | {"jobs": [known[run] for run in runs], "cases": own})
        for path in folder.glob("*.json"):
            if path.stem not in by_experiment:
                path.unlink()


def _entry(job: Planned) -> dict[str, Any]:
    return {"overrides": list(job.composed.overrides), "run": job.run, "command": job.composed.command}


def _questions(ledger: Sequence[Assumption], claims: Mapping[str, Claim], paths: Paths) -> Iterator[Question]:
    asked = [(row, trial, _claim(claims, name, row)) for row in ledger for trial in row.trials for name in trial.claims]
    groups = dict.fromkeys((claim.experiment, trial.both) for _, trial, claim in asked)
    jobs = {group: _jobs(*group) for group in groups}
    made = iter(planned([job for group in groups for job in jobs[group]], paths))
    ready = {group: [next(made) for _ in jobs[group]] for group in groups}
    for row, trial, claim in asked:
        answers = [
            job
            for job in answering(claim, ready[claim.experiment, trial.both])
            if not trial.only or trial.only in job.composed.overrides
        ]
        if not answers:
            raise UserError(f"assumptions.yaml, {row.id}: no job of {claim.experiment} answers {claim.name}")
        yield Question(row, trial, claim, tuple(answers))


def _jobs(experiment: str, both: str) -> list[tuple[str, ...]]:
    own = both.split()
    members = [] if any(override.startswith("seeds=") for override in own) else [f"seeds={MEMBERS}"]
    return expand([f"experiment={experiment}", f"scale={SCALE}", "record=false", *members, *own])


def _instead(ours: Planned, alternative: str) -> tuple[str, ...]:
    """The overrides of the job that takes our job's place; our own where the alternative does not concern it."""
    given = [override for override in alternative.split() if _concerns(ours, override)]
    keys = {override.partition("=")[0] for override in given}
    return (*(o for o in ours.composed.overrides if o.partition("=")[0] not in keys), *given)


def _concerns(job: Planned, override: str) -> bool:
    key = override.partition("=")[0]
    return key != "metric" and _value(job.composed.config.model_dump(), key.split(".")) is not _ABSENT


_ABSENT = object()


def _value(section: Any, path: Iterable[str]) -> Any:
    for part in path:
        if not isinstance(section, dict) or part not in section:
            return _ABSENT
        section = section[part]
    return section


def _choice(ours: Planned, alternative: str) -> str:
    """What our job has where the alternative has something else, spelt like it."""
    config, said = ours.composed.config.model_dump(), []
    for override in alternative.split():
        key = override.partition("=")[0]
        value = _value(config, key.split("."))
        if isinstance(value, dict):
            value = value.get("regime") or value.get("reading") or value.get("name") or value.get("kind")
        if value is not _ABSENT:
            said.append(f"{key}={str(value).lower() if value is None or isinstance(value, bool) else value}")
    return " ".join(said)


def _refuse_idle(cases: Sequence[Case]) -> None:
    """An alternative that changes no run of a claim tells nothing."""
    groups: dict[tuple[str, str, str], list[Case]] = {}
    for case in cases:
        groups.setdefault((case.assumption, case.alternative, case.claim), []).append(case)
    for (assumption, alternative, claim), own in groups.items():
        if not alternative.startswith("metric=") and all(case.run == case.instead for case in own):
            raise UserError(f"assumptions.yaml, {assumption}: {alternative} changes no run that answers {claim}")


def _claim(claims: Mapping[str, Claim], name: str, row: Assumption) -> Claim:
    if name not in claims:
        raise UserError(f"assumptions.yaml, {row.id}: no claim is called {name}; there are {', '.join(claims)}")
    return claims[name]
