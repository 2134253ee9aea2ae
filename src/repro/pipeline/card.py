"""The run card: which settings had a part in a run, and which of them are not the usual ones."""

from collections.abc import Sequence
from dataclasses import replace

from repro.config.defaults import defaults_of
from repro.config.rules import linear
from repro.config.schema import Config, scaled
from repro.results.run_card import RunCard
from repro.tracking.plain_data import Json, flattened

SHOWN_DIGITS = 10  # of the digest of a recording

# Settings and groups that no number of a run depends on, with the reason.
WITHOUT_EFFECT = {
    "experiment": "says where the run is listed",
    "sweep": "belongs to the experiment",
    "explicit": "decides what the scale cuts of settings that are listed themselves",
    "record": "decides whether a recording is written",
    "seeds": "are the members; runs that differ in seeds alone are pooled",
    "metric.": "adds numbers to those of a run, and changes none of them",
    "scale.": "is applied to samples, epochs, iterations and loops, which are settings of their own",
}


def card_of(config: Config) -> RunCard:
    """The card of a configuration at its scale, with nothing measured."""
    settings = used_settings(config)
    usual = used_settings(scaled(defaults_of(config)))
    changed = frozenset(key for key, value in settings.items() if key not in usual or usual[key] != value)
    return RunCard(settings, changed, {})


def summary_of(
    config: Config, *, n_train: int, n_parameters: int, status: Sequence[str], notes: Json, sha256: str = ""
) -> Json:
    """What run.json holds of the card of a run: settings and changed ones, and columns for lists of runs.

    status  one word per member, as the fit left it, as are the notes
    sha256  of the files of a recording
    """
    card = replace(card_of(config), measured={"n_train": n_train, "epochs": notes.get("epochs", 0)})
    counted = {
        "seeds": config.members,
        "member_status": list(status),
        "notes": {key: value for key, value in notes.items() if key != "epochs"},
        "n_parameters": n_parameters,
        "sha256": sha256[:SHOWN_DIGITS] or None,
    }
    return {
        "card": {name: None if value == "" else value for name, value in card.run_columns().items()} | counted,
        "settings": dict(card.settings),
        "changed": sorted(card.changed),
    }


def used_settings(config: Config) -> dict[str, object]:
    """Every setting that had a part in a run, by dotted key; `config` is at its scale."""
    flat = flattened(config.model_dump(mode="json"))
    unused = _unused(flat, config)
    groups = tuple(place for place in unused if place.endswith("."))
    used = {key: value for key, value in flat.items() if key not in unused and not key.startswith(groups)}
    return used | ({} if flat["control.kind"] == "none" else {"control.loops": config.loops})


def _unused(flat: Json, config: Config) -> list[str]:
    """Settings, and groups (with a dot at their end), that this run did not read."""
    fitted, sequence = config.model.fitted, config.sequence
    unused = [*WITHOUT_EFFECT]
    if not fitted:
        unused += ["objective.", "optimiser."]
    if not fitted or not config.model.uses_basis:
        unused.append("basis.")
    if linear(config):
        unused.append("model.hidden")
    if not fitted or not sequence.uses_free_motion:
        unused += ["sequence.grid", "sequence.initial_angles", "sequence.steps"]
    if not fitted or not (sequence.begins_with_free_motion and sequence.ends_on_data):
        unused.append("sequence.pretraining_epochs")
    if flat.get("data.regime") == "long":
        unused.append("data.episode_steps")
    if flat["control.kind"] == "none":
        unused.append("task.")
    if config.own_coordinates:
        unused += ["system.", "reading."]
    return unused
