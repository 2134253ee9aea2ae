"""The run card: what was run, in the columns that every table is made from."""

from collections.abc import Mapping, Sequence
from typing import Any

from repro.config.registry import settings
from repro.config.rules import FREE_MOTION
from repro.config.rules import linear as is_linear
from repro.config.schema import Config, File, RandomForce
from repro.pipeline.as_printed import is_literal
from repro.tracking.plain_data import plain_copy

# What is told elsewhere on the card, or changes no result.
TOLD = ("kind", "hidden", "momentum_hidden", "momentum_weight", "l1_kinetic", "l1_potential", "passivity_states")
NOISES = ("tau_noise", "qdd_noise", "q_noise", "qd_noise")


def run_card(
    config: Config, *, n_train: int, n_parameters: int, status: Sequence[str], notes: Mapping[str, Any]
) -> dict[str, Any]:
    """The card of a run at its scale; status (a word a member) and notes as the fit left them."""
    model, objective, fitted = config.model.plain(), config.objective, config.model.fitted
    basis = config.basis.name if config.model.has_coefficients else None
    linear = is_linear(config)
    kind = "_l1" if objective.l1_kinetic or objective.l1_potential else ""
    kind += "_from_start" if getattr(config.optimiser, "regularise_towards", None) == "start" else ""
    return {
        "system": config.system.name,
        "reading": config.reading.name,
        **_of_data(config.data),
        "damping": config.system.damping,
        "n_train": n_train,
        "model": model["kind"],
        "basis": basis,
        "options": _options(config) if fitted else None,
        "hidden": None if linear else _layers(model.get("hidden") or []) or None,
        "objective": objective.kind if fitted else None,
        "optimiser": config.optimiser.name + kind if fitted else None,
        "sequence": config.sequence.kind,
        **_of_free_motion(config),
        "energies": config.energies.gauge,
        "energy_form": config.sequence.energy_form,
        "control": config.control.name if config.control.kind != "none" else None,
        "momentum_weight": objective.momentum_weight,
        "momentum_hidden": _layers(model.get("momentum_hidden") or []),
        "curriculum": "-".join(str(steps) for steps in config.curriculum.episodes) or None,
        "epochs": notes.get("epochs", 0),
        "seeds": config.members,
        "literal": is_literal(config),
        "member_status": list(status),
        "notes": {key: value for key, value in notes.items() if key != "epochs"},
        "n_parameters": n_parameters,
    }


def _options(config: Config) -> str | None:
    """Options without a column of their own, where not their setting's: of model, objective, friction, starts."""
    starts = {key: value for key, value in config.optimiser.plain().items() if key == "restarts"}
    changed = []
    for group, option, chosen in (
        ("model", config.model.kind, config.model.plain()),
        ("objective", config.objective.kind, config.objective.model_dump()),
        ("optimiser", config.optimiser.name, starts),
        ("system", config.system.name, {"damping_growth": config.system.damping_growth}),
    ):
        usual = settings(group, option)
        changed += [
            f"{key}={str(value).lower()}"
            for key, value in plain_copy(chosen).items()
            if key not in TOLD and value != usual.get(key, value)
        ]
    return ", ".join(changed) or None


def _of_free_motion(config: Config) -> dict[str, Any]:
    sequence = config.sequence
    used = sequence.kind in FREE_MOTION and config.model.fitted
    first = sequence.kind == "pretrain" and used
    return {
        "grid": f"{sequence.grid} of {sequence.initial_angles}" if used else None,
        "pretraining_epochs": (sequence.pretraining_epochs or config.optimiser.length or None) if first else None,
    }


def _of_data(data: RandomForce | File) -> dict[str, Any]:
    if isinstance(data, File):
        unknown = {"regime": "file", "episode_steps": None, "labels": "measured", "noise": False, "reset": None}
        return unknown | dict.fromkeys(NOISES, 0.0)
    noises = {name: getattr(data, name) for name in NOISES}
    return {
        "regime": data.regime,
        "episode_steps": data.episode_steps if data.regime == "episodes" else None,
        "labels": data.labels,
        "noise": any(noises.values()),
        **noises,
        "reset": data.reset,
    }


def _layers(hidden: Sequence[int]) -> str:
    """10, 2x32 or 10-5: layers times width where all are equal."""
    if len(hidden) > 1 and len(set(hidden)) == 1:
        return f"{len(hidden)}x{hidden[0]}"
    return "-".join(str(units) for units in hidden)
