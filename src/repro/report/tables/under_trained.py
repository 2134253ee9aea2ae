"""Whether a fit with a budget of CPU time had come to its end: its error against that after a part of the budget."""

import math
from collections.abc import Sequence

from repro.report.writing import ABSENT
from repro.results.columns import Settings
from repro.results.run_setting import RunSetting

BUDGET = "optimiser.budget_s"
STILL_FALLS = 0.9  # to less than this share of the error after at most half of the budget
TRAINED = "to its end"
UNDER_TRAINED = "under-trained"


def training_of(setting: RunSetting, others: Sequence[RunSetting]) -> str:
    """Compare a setting with the one of the longest shorter budget, at most half of its own, that is equal otherwise.

    The median MAE of accelerations decides. A setting without a budget, such another, or a finite error has no mark.
    """
    own, after = _budget(setting), setting.estimate("mae_qdd").median
    shorter = {
        _budget(each): each for each in others if 2 * _budget(each) <= own < math.inf and _rest(each) == _rest(setting)
    }
    if not shorter or not math.isfinite(after):
        return ABSENT
    before = shorter[max(shorter)].estimate("mae_qdd").median
    return UNDER_TRAINED if after < STILL_FALLS * before else TRAINED


def _budget(setting: RunSetting) -> float:
    budget = setting.settings.get(BUDGET)
    return float(budget) if isinstance(budget, int | float) else math.inf


def _rest(setting: RunSetting) -> Settings:
    return {key: value for key, value in setting.settings.items() if key != BUDGET}
