"""`repro run`: one configuration, or many with -m."""

import sys
from argparse import Namespace
from collections.abc import Sequence

import yaml

from repro.config.compose import plan
from repro.config.overrides import belongs, expand, experiment_of, setting
from repro.errors import UserError
from repro.launch import cluster
from repro.launch.pool import start_server
from repro.sweep.listing import list_jobs
from repro.sweep.missing import preload, run_missing
from repro.sweep.planned_job import PlannedJob, plan_jobs, total
from repro.sweep.search import SearchOptions, search
from repro.sweep.search import split as split_search
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.store import Store
from repro.tracking.text import duration, table

_MOST_SHOWN = 5  # runs of a search


def main(arguments: Namespace) -> int:
    """Run one configuration, or with -m every one that the lists and the experiment make; 1 when a job failed."""
    if arguments.cfg not in (None, "job"):
        if "=" not in arguments.cfg:
            raise UserError(f"--cfg {arguments.cfg}: there is --cfg job only, the resolved configuration of a run")
        arguments.overrides.insert(0, arguments.cfg)  # --cfg basis=t2: what follows is an override
    own, wanted = split_search(arguments.overrides)
    if wanted is not None:
        return _search(own, wanted, arguments)
    own, where = cluster.split(own)
    if where:
        cluster.refuse({"--workers": arguments.workers, "--timeout": arguments.timeout}, where)
    overrides = _jobs(own, arguments.paired, sweep=arguments.multirun or arguments.dry_run)
    if arguments.cfg:
        for composed in plan(overrides):
            content = composed.config.model_dump(mode="json", exclude={"sweep"})
            print(yaml.safe_dump(content, sort_keys=False, default_flow_style=None), end="")
        return 0
    paths = Paths(outputs_root())
    here = not where and not arguments.dry_run
    jobs = plan_jobs(overrides, paths, on_unknown=lambda jobs: start_server(preload(jobs)) if here else None)
    if arguments.failed:
        store = Store(paths.root)
        jobs = [job for job in jobs if job.failures(store)]
    if arguments.dry_run:
        return _print_plan(jobs)
    list_jobs(paths, jobs)
    results = run_missing(jobs, paths, arguments.workers, arguments.timeout, where)
    _print_outcome(jobs, paths)
    return 1 if any(not result.ok for result in results) else 0


def _search(overrides: Sequence[str], wanted: SearchOptions, options: Namespace) -> int:
    """Search for the best value of a metric and print the best runs."""
    if not options.multirun or options.dry_run or options.cfg or options.paired or options.failed:
        raise UserError("hydra/sweeper=optuna goes with -m, --workers and --timeout alone")
    paths = Paths(outputs_root())
    best = search(overrides, wanted, paths, options.workers, options.timeout)
    if not best:
        print(f"no run gave a value of {wanted.metric}", file=sys.stderr)
        return 1
    rows = [[run.job.run, f"{run.value:.4g}", run.job.composed.command] for run in best[:_MOST_SHOWN]]
    print(table(rows, ["best first", wanted.metric, "command"]))
    return 0


def _jobs(overrides: Sequence[str], paired: bool, sweep: bool) -> list[tuple[str, ...]]:
    """The jobs of a command line; without `sweep` there must be one."""
    jobs = expand(overrides, paired=paired, lines=sweep)
    if not sweep and experiment_of(jobs[0]) and not setting(jobs[0]) and not belongs(jobs[0]):
        jobs = expand(overrides, paired=paired)
    if not sweep and len(jobs) > 1:
        raise UserError(f"this makes {len(jobs)} jobs: add -m to run them all, or --dry-run to list them")
    return jobs


def _print_plan(jobs: Sequence[PlannedJob]) -> int:
    for job in jobs:
        state = "done" if job.record else f"to run, about {duration(job.expected_seconds)}"
        print(f"{job.run}  {state}\n  {job.composed.command}")
    print(total(jobs))
    return 0


def _print_outcome(jobs: Sequence[PlannedJob], paths: Paths) -> None:
    store = Store(paths.root)
    for job in jobs:
        record = job.pipeline.finished(store)
        if record is None:
            continue
        medians = {name: record.summary["median"].get(name) for name in ("mae_tau", "mae_qdd", "mae_H_centred")}
        text = ", ".join(f"{name} {value:.3g}" for name, value in medians.items() if value is not None)
        print(f"{record.id}: {text} (medians of {len(job.composed.config.members)} members)")
