"""A fit that had no time to come to its end is marked, by its error after a part of the same budget."""

import json

import pytest

from repro.report.tables.models import TRAINED, UNDER_TRAINED, training_of
from repro.report.writing import ABSENT
from repro.results.run_setting import Measured, RunSetting


def setting(error: float, budget: float | None, rate: float = 0.01) -> RunSetting:
    """One member with this error of accelerations."""
    config = {"optimiser.learning_rate": rate} | ({} if budget is None else {"optimiser.budget_s": budget})
    name = f"{error}-{budget}-{rate}"
    run = {"run": name, "config": json.dumps(config), "seeds": [0], "member_status": ["ok"], "changed": ""}
    return RunSetting({}, (run,), {name: {("mae_qdd", "test"): Measured("rad/s^2", {0: error})}})


@pytest.mark.parametrize(
    ("error", "budget", "mark"),
    [
        (0.89, 50.0, UNDER_TRAINED),  # 1.0 after 17 s
        (0.91, 50.0, TRAINED),
        (0.5, 30.0, ABSENT),  # 17 s are more than half of it
        (0.5, 17.0, ABSENT),
        (0.5, None, ABSENT),
        (float("nan"), 50.0, ABSENT),
    ],
)
def test_the_error_after_part_of_the_budget_decides(error, budget, mark):
    others = [setting(1.0, 17.0), setting(0.1, 17.0, rate=0.003)]
    assert training_of(setting(error, budget), others) == mark


def test_the_longest_shorter_budget_is_compared():
    assert training_of(setting(0.95, 150.0), [setting(1.0, 50.0), setting(9.0, 17.0)]) == TRAINED
