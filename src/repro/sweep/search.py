"""A search over settings for the best value of a metric, by Optuna (the extra `search`): hydra/sweeper=optuna."""

import importlib.util
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from repro.config.overrides import key_of, parsed
from repro.errors import UserError
from repro.launch.machine import allowed_cores
from repro.plugins.checked import validated
from repro.plugins.options import Count, Natural, Options
from repro.plugins.plugin import nearest
from repro.sweep.missing import run_missing
from repro.sweep.planned_job import PlannedJob, plan_jobs
from repro.tracking.paths import Paths
from repro.tracking.store import Store

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution

CHOSEN = "hydra/sweeper=optuna"
SETTING = "hydra.sweeper."


@dataclass(frozen=True)
class SearchOptions(Options):
    """Options of a search: hydra.sweeper.NAME=VALUE."""

    metric: str = "mae_tau"  # of the test part, the median over the members
    n_trials: Count = 20  # runs in all, those that are stored already included
    direction: Literal["minimize", "maximize"] = "minimize"
    seed: Natural = 0  # of the sampler


@dataclass(frozen=True)
class FoundRun:
    """A finished run of a search, and its value of the metric."""

    job: PlannedJob
    value: float


def split(overrides: Sequence[str]) -> tuple[list[str], SearchOptions | None]:
    """The overrides without those of a search, and its options where one is chosen."""
    if CHOSEN not in overrides:
        return list(overrides), None
    if importlib.util.find_spec("optuna") is None:
        raise UserError(f"{CHOSEN} needs an extra: pip install -e '.[search]' in the project's folder")
    own = [override for override in overrides if override.startswith(SETTING)]
    rest = [override for override in overrides if override not in (CHOSEN, *own)]
    given = dict(override.removeprefix(SETTING).partition("=")[::2] for override in own)
    return rest, validated(SearchOptions, SETTING.rstrip("."), given)


def search(
    overrides: Sequence[str], options: SearchOptions, paths: Paths, workers: int | None, timeout: float | None
) -> list[FoundRun]:
    """Run the trials, `workers` at once; returns those that gave a value, the best first. UserError for no space."""
    import optuna
    from optuna.trial import TrialState

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    space = {key_of(override): chosen for override in overrides if (chosen := distribution(override)) is not None}
    if not space:
        raise UserError("a search needs something to choose: optimiser.learning_rate=interval(1e-4,1e-1), basis=t1,t2")
    fixed = [override for override in overrides if key_of(override) not in space]
    sampler = optuna.samplers.TPESampler(seed=options.seed, constant_liar=True)
    study = optuna.create_study(direction=options.direction, sampler=sampler)
    store, workers = Store(paths.root), workers or allowed_cores()
    found: dict[str, FoundRun] = {}
    for first in range(0, options.n_trials, workers):
        trials = [study.ask(space) for _ in range(min(workers, options.n_trials - first))]
        chosen = [[f"{key}={value}" for key, value in trial.params.items()] for trial in trials]
        jobs = plan_jobs([(*fixed, *own) for own in chosen], paths)
        run_missing(jobs, paths, workers, timeout)
        for trial, job in zip(trials, jobs, strict=True):
            value = _value(job, store, options.metric)
            if value is None or math.isnan(value):
                study.tell(trial, state=TrialState.FAIL)
                continue
            study.tell(trial, value)
            found[job.run] = FoundRun(job, value)
    return sorted(found.values(), key=lambda trial: trial.value, reverse=options.direction == "maximize")


def distribution(override: str) -> "BaseDistribution | None":
    """What a sweep of Hydra's grammar lets Optuna choose from; None for a single value.

    Of an interval or a range tagged `log`, as in tag(log, interval(1e-4, 1e-1)), the logarithm is uniform.
    """
    from hydra.core.override_parser.types import IntervalSweep, RangeSweep
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    one = parsed(override)
    if not one.is_sweep_override():
        return None
    value = one.value()
    if isinstance(value, IntervalSweep):
        low, high, log = value.start, value.end, "log" in value.tags
        if isinstance(low, int) and isinstance(high, int):
            return IntDistribution(low, high, log=log)
        return FloatDistribution(float(low or 0.0), float(high or 0.0), log=log)
    if isinstance(value, RangeSweep) and isinstance(value.start, int) and isinstance(value.step, int):
        steps = (int(value.stop or 0) - 1 - value.start) // value.step
        return IntDistribution(value.start, value.start + steps * value.step, step=value.step)
    return CategoricalDistribution([*one.sweep_string_iterator()])


def _value(job: PlannedJob, store: Store, metric: str) -> float | None:
    record = job.pipeline.finished(store)
    if record is None:
        return None
    medians = record.summary["median"]
    if metric not in medians:
        raise UserError(f"{SETTING}metric={metric}: a run has {', '.join(sorted(medians))}{nearest(metric, medians)}")
    return float(medians[metric])
