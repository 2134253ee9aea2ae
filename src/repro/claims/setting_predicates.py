"""Statements about the members of one setting, or of each setting of a family."""

import math
from typing import Literal

import numpy as np

from repro.claims.evidence import CardSelector, Decision, Evidence, Finding, StatementPredicate
from repro.claims.yaml_rows import Number, Text
from repro.results.run_setting import RunSetting
from repro.results.selectors import TRIVIAL, NotRunError, anchor, one_setting, settings, test_set_of
from repro.results.statistics import Estimate, share


class MedianBound(StatementPredicate):
    """The median member lies below, or above, `value`."""

    name: Literal["median_below", "median_above"]
    where: CardSelector
    metric: Text
    value: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the median with the value."""
        setting, measured = evidence.measured(self.where, self.metric)
        side = self.name.removeprefix("median_")
        decision = (Decision.below if side == "below" else Decision.above)(measured, self.value)
        note = f"criterion: {side} {self.value:g}"
        return Finding(self.metric, setting.unit(self.metric), measured, note, setting.rows, decision=decision)


class AllMembersAwayFrom(StatementPredicate):
    """Every member that finished lies at least `distance` from `value`."""

    name: Literal["all_members_away_from"]
    where: CardSelector
    metric: Text
    value: Number
    distance: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the distance of every finished member."""
        setting, measured = evidence.measured(self.where, self.metric)
        members = setting.values(self.metric)
        finished = members[np.isfinite(members)]
        holds = finished.size > 0 and bool(np.all(np.abs(finished - self.value) >= self.distance))
        note = f"criterion: every member {self.distance:g} or more away from {self.value:g}"
        decision = Decision.certain(holds)
        return Finding(self.metric, setting.unit(self.metric), measured, note, setting.rows, decision=decision)


class EverySettingBelow(StatementPredicate):
    """Every member of every setting that `where` selects lies below `value`; a failed member does not."""

    name: Literal["every_setting_below"]
    where: CardSelector
    metric: Text
    value: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Compare every member of the family; the worst one is shown."""
        family = [s for s in settings(evidence.results, evidence.experiment, self.where) if s.values(self.metric).size]
        if not family:
            raise NotRunError(f"{self.metric} was not measured in {evidence.experiment}")
        members = np.concatenate([setting.values(self.metric) for setting in family])
        worst = float(np.nanmax(members)) if np.isfinite(members).any() else math.inf
        estimate = Estimate(worst, math.nan, math.nan, members.size, int(np.sum(~np.isfinite(members))))
        note = f"criterion: every member of {len(family)} settings below {self.value:g}; the worst is shown"
        decision, unit = Decision.certain(bool(np.all(members < self.value))), family[0].unit(self.metric)
        rows = [row for setting in family for row in setting.rows]
        return Finding(f"worst {self.metric}", unit, estimate, note, rows, decision=decision)


class ShareOfFailures(StatementPredicate):
    """At least, or at most, this share of fits diverges, is worse than the trivial MAE q̈, or has min eig M <= 0."""

    name: Literal["share_of_failures_at_least", "share_of_failures_at_most"]
    where: CardSelector
    share_of_members: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Count the fits that failed."""
        setting, failures, causes = _failures(evidence, self.where)
        side = self.name.removeprefix("share_of_failures_at_")
        bound = self.share_of_members
        decision = Decision.at_least(failures, bound) if side == "least" else Decision.at_most(failures, bound)
        note = f"criterion: at {side} {bound:g}; {causes}"
        return Finding("share of failed fits", "1", failures, note, setting.rows, decision=decision)


class FailsMoreOften(StatementPredicate):
    """The share of failed fits, as ShareOfFailures counts them, lies above that of `against`, interval by interval."""

    name: Literal["fails_more_often"]
    where: CardSelector
    against: CardSelector

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the intervals of both shares."""
        setting, failures, causes = _failures(evidence, self.where)
        opponent, others, other_causes = _failures(evidence, self.against)
        note = f"criterion: more often than {others.median:.3g} [{others.low:.3g}, {others.high:.3g}]; "
        note += f"{causes}; the others, {other_causes}"
        rows, decision = (*setting.rows, *opponent.rows), Decision.greater(failures, others)
        return Finding("share of failed fits", "1", failures, note, rows, decision=decision)


SettingPredicate = MedianBound | AllMembersAwayFrom | EverySettingBelow | ShareOfFailures | FailsMoreOften


def _failures(evidence: Evidence, where: CardSelector) -> tuple[RunSetting, Estimate, str]:
    """The setting that is meant, its share of failed fits, and their causes in words."""
    setting = one_setting(evidence.results, evidence.experiment, where)
    errors, least = setting.values("mae_qdd"), setting.values("min_eig_M")
    if errors.size == 0:
        raise NotRunError(f"mae_qdd was not measured in {evidence.experiment}")
    trivial = anchor(evidence.results, evidence.experiment, TRIVIAL, test_set_of(setting.card))
    bound = trivial.estimate("mae_qdd").median if trivial else math.inf
    # A failed member is nan, for which no comparison holds.
    sound = errors <= bound
    if least.size:
        sound &= least > 0
    causes = [
        f"{setting.failed} diverged",
        f"{int(np.sum(errors > bound))} worse than the trivial model" if trivial else "trivial model not run",
        f"{int(np.sum(least <= 0))} with an indefinite mass matrix" if least.size else "min eig M not measured",
    ]
    return setting, share(~sound), f"of {setting.n} members: " + ", ".join(causes)
