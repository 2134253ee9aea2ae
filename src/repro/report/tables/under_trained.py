"""Whether a fit with a budget of CPU time had come to its end: its error against that after a part of the budget."""

from collections.abc import Mapping, Sequence

import numpy as np

from repro.report.writing import ABSENT
from repro.results.run_setting import RunSetting

BUDGET = "optimiser.budget_s"
STILL_FALLS = 0.9  # to less than this share of the error after at most half of the budget
TRAINED = "to its end"
UNDER_TRAINED = "under-trained"


def training_of(setting: RunSetting, others: Sequence[RunSetting]) -> str:
    """Compare a setting with the one of the longest shorter budget, at most half of its own, that is equal otherwise.

    The median MAE of accelerations decides. A setting without a budget, such another, or a finite error has no mark.
    """
    budget = _budget(setting)
    if budget is None:
        return ABSENT
    rest = _rest(setting.settings)
    shorter = {
        other_budget: other
        for other in others
        if (other_budget := _budget(other)) is not None and 2 * other_budget <= budget and _rest(other.settings) == rest
    }
    if not shorter:
        return ABSENT
    before, after = _error(shorter[max(shorter)]), _error(setting)
    if not np.isfinite(after):
        return ABSENT
    return UNDER_TRAINED if after < STILL_FALLS * before else TRAINED


def _budget(setting: RunSetting) -> float | None:
    budget = setting.settings.get(BUDGET)
    return float(budget) if isinstance(budget, int | float) else None


def _rest(settings: Mapping[str, object]) -> dict[str, object]:
    return {key: value for key, value in settings.items() if key != BUDGET}


def _error(setting: RunSetting) -> float:
    """The median over the members, those that failed infinitely wrong."""
    values = setting.values("mae_qdd")
    return float(np.median(np.nan_to_num(values, nan=np.inf))) if values.size else float("inf")
