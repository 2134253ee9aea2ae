"""No setting is forgotten: whatever changes a run changes its row of the tables, and the two runs are not alike."""

import json
import re
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

import pytest

from repro.config.places import CONF
from repro.config.registry import groups, read_settings, settings
from repro.config.schema import Config, scaled
from repro.errors import UserError
from repro.pipeline.card import WITHOUT_EFFECT, card_of
from repro.results.run_card import RunCard
from repro.results.run_setting import RunSetting
from repro.results.selectors import alike
from repro.tracking.plain_data import flattened

WHOLE = read_settings(CONF / "config.yaml")
CHOSEN = {group: option for entry in WHOLE["defaults"] if entry != "_self_" for group, option in entry.items()}
OUTSIDE = {key: value for key, value in WHOLE.items() if key != "defaults"}
CHOICES = ("kind", "name", "source")  # keys that choose among options, whose other settings go with them
# At the scale of the paper nothing is cut; a task is read by a controller, and a basis by some models only.
READ_WITH = {"scale": "paper", "control": "sip", "model": "lagrangian"}
OF_D_H = ("sequence.grid", "sequence.initial_angles", "sequence.steps")
# What an option does not read.
UNREAD = {
    ("sequence", "main"): (*OF_D_H, "sequence.pretraining_epochs"),
    ("sequence", "anchored"): (*OF_D_H, "sequence.pretraining_epochs"),
    ("sequence", "joint"): ("sequence.pretraining_epochs",),
    ("sequence", "pretrain_only"): ("sequence.pretraining_epochs",),
    ("data", "long"): ("data.episode_steps",),
}


def _raw(**options: str) -> dict[str, Any]:
    return {**OUTSIDE, **{group: settings(group, option) for group, option in (CHOSEN | options).items()}}


def _parsed(raw: Mapping[str, Any]) -> Config:
    return scaled(Config.model_validate(raw))


def _with(raw: Mapping[str, Any], key: str, value: object) -> dict[str, Any]:
    first, _, rest = key.partition(".")
    inner = raw.get(first)
    return {**raw, first: _with(inner if isinstance(inner, dict) else {}, rest, value) if rest else value}


def _candidates(value: object) -> list[object]:
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int | float):
        return [candidate for candidate in (value // 2, value + 1, value / 2 + 0.1) if candidate != value]
    if isinstance(value, list):
        shifted = [each + 0.5 if isinstance(each, float) else each for each in value]
        return [candidate for candidate in (shifted, [*value, 3], [*value, "other"], [3]) if candidate != value]
    if value == {}:
        return [{"x": 0.5}]
    return [3, 0.5, [3], True, "other"]


def _changed(raw: Mapping[str, Any], key: str, value: object) -> Config:
    """The configuration with another valid value of a key; the words that an error allows are tried too."""
    allowed: list[object] = []
    for candidate in _candidates(value):
        try:
            return _parsed(_with(raw, key, candidate))
        except (ValueError, UserError) as error:
            allowed += [word for word in re.findall(r"'(\w+)'", str(error)) if word not in (value, candidate)]
    for word in allowed:
        try:
            return _parsed(_with(raw, key, word))
        except (ValueError, UserError):
            continue
    raise AssertionError(f"no other value of {key} = {value!r} is accepted")


def _setting(card: RunCard) -> RunSetting:
    config, changed = json.dumps(dict(card.settings)), " ".join(card.changed)
    row = {**card.run_columns(), "as_printed": False, "config": config, "changed": changed}
    return RunSetting(row, (row,))


def _forgotten(raw: Mapping[str, Any], group: str) -> Iterator[str]:
    usual = _parsed(raw)
    before = card_of(usual)
    for key, value in flattened({group: usual.model_dump(mode="json")[group]}).items():
        if key in WITHOUT_EFFECT or key.rpartition(".")[2] in CHOICES:
            continue
        after = card_of(_changed(raw, key, value))
        if before.run_columns() == after.run_columns() or alike(_setting(before), _setting(after)):
            yield key


SEEN = [group for group in groups() if f"{group}." not in WITHOUT_EFFECT]
OPTIONS = [(group, option) for group in SEEN for option in groups()[group]]


@pytest.mark.parametrize(("group", "option"), OPTIONS)
def test_every_setting_of_every_option_tells_two_runs_apart(group, option):
    assert {*_forgotten(_raw(**READ_WITH | {group: option}), group)} == {*UNREAD.get((group, option), ())}


@pytest.mark.parametrize("group", [group for group in SEEN if group != "data"])
def test_every_two_options_of_a_group_are_told_apart(group):
    cards = {option: card_of(_parsed(_raw(**READ_WITH | {group: option}))) for option in groups()[group]}
    for (a, before), (b, after) in combinations(cards.items(), 2):
        assert not alike(_setting(before), _setting(after)), (a, b)


@pytest.mark.parametrize("key", sorted(OUTSIDE.keys() - WITHOUT_EFFECT.keys()))
def test_every_setting_outside_the_groups_does_too(key):
    assert [*_forgotten(_raw(**READ_WITH), key)] == []


@pytest.mark.parametrize("optimiser", ["adam", "levenberg_marquardt"])
def test_what_a_scale_cuts_is_seen_in_the_settings_that_it_cuts(optimiser):
    raw = _raw(optimiser=optimiser, sequence="pretrain", control="sip", task="random")
    usual = _parsed(raw)
    unseen = []
    for key, value in flattened({"scale": settings("scale", CHOSEN["scale"])}).items():
        other = _changed(raw, key, value)
        same = usual.model_copy(update={"scale": None}) == other.model_copy(update={"scale": None})
        if not same and alike(_setting(card_of(usual)), _setting(card_of(other))):
            unseen.append(key)
    assert unseen == []


def test_the_usual_settings_are_no_options():
    for group, option in OPTIONS:
        assert card_of(_parsed(_raw(**READ_WITH | {group: option}))).changed == set(), (group, option)
