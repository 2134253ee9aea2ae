"""Statements about a whole family of settings: they hold when they hold for every one of them."""

import math

import numpy as np

from repro.claims.predicates import Evidence, Outcome
from repro.results.selectors import NotRunError, Where, settings
from repro.results.statistics import Estimate


def every_setting_below(evidence: Evidence, *, metric: str, value: float, where: Where) -> Outcome:
    """Hold when every member of every setting that `where` means lies below `value`; a failed member does not."""
    found = [s for s in settings(evidence.results, evidence.experiment, where) if s.values(metric).size]
    if not found:
        raise NotRunError(f"{metric} was not measured in {evidence.experiment}")
    members = np.concatenate([setting.values(metric) for setting in found])
    worst = float(np.nanmax(members)) if np.isfinite(members).any() else math.inf
    estimate = Estimate(worst, math.nan, math.nan, members.size, int(np.sum(~np.isfinite(members))))
    note = f"asked: every member of {len(found)} settings below {value:g}; the worst is shown"
    holds = bool(np.all(members < value))
    return Outcome(holds, f"worst {metric}", found[0].unit(metric), estimate, note, tuple(found))
