"""The defaults that options declare in code are those of their files in conf/."""

from dataclasses import MISSING, fields

import pytest

from repro.config.registry import groups, settings
from repro.data.data_options import RandomForce
from repro.learning.objective_options import OBJECTIVES
from repro.learning.sequence_options import SEQUENCES
from repro.plugins.options import plain
from repro.plugins.plugin import plugin

FOLDERS = {
    "model": "models.kinds", "optimiser": "learning.optimisers", "control": "control.controllers",
    "objective": OBJECTIVES, "sequence": SEQUENCES,
}  # fmt: skip
DECLARED = {"data": RandomForce}
# By which keys the options of one group differ from each other, on purpose.
CHOSEN = {"kind", "name", "source", "regime", "force_limit"}
BUDGET = {"schedule", "decay", "epochs", "learning_rate", "batch_size", "budget_s"}
VARIANTS = {"adam_cosine": {"schedule", "decay"}, "adam_budget": BUDGET, "sgd": {"rule"}, "lasso": {"method"}}
# The files of control are settings of one controller each: their base holds the defaults.
NO_DEFAULTS = {("data", "file"), *(("control", option) for option in groups()["control"])}
FILES = [(group, option) for group in (*FOLDERS, *DECLARED) for option in groups()[group]]
FILES = [("control", "_mpc"), *(file for file in FILES if file not in NO_DEFAULTS)]


@pytest.mark.parametrize(("group", "option"), FILES)
def test_defaults_in_code_and_in_files_agree(group, option):
    stored = settings(group, option)
    declared = DECLARED[group] if group in DECLARED else plugin(FOLDERS[group], stored["kind"]).Options
    differing = {}
    for field in fields(declared):
        if field.default is MISSING or field.name not in stored or field.name in CHOSEN | VARIANTS.get(option, set()):
            continue
        value, default = stored[field.name], plain(field.default)
        if value != default:
            differing[field.name] = (default, value)
    assert not differing
