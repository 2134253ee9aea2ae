"""Settings that are right one by one and cannot go together: one small rule an idea."""

from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path

from repro.config import Config, File
from repro.errors import UserError
from repro.messages import choose
from repro.options import choices, optimiser_class

ANCHOR_ROWS = ("trivial", "degenerate")
FREE_MOTION = ("d_h_only", "d_h_then_d", "joint")


def impossible(config: Config) -> Iterator[str]:
    """What cannot be run, a line a reason; the names come first, for the rules look at what they name."""
    unknown = [*_unknown_names(config)]
    yield from unknown or (line for rule in RULES for line in rule(config))


def _unknown_names(config: Config) -> Iterator[str]:
    named = {
        "system.name": (config.system.name, choices("repro.mechanics.systems")),
        "basis.name": (config.basis.name, choices("repro.models.bases")),
    }
    yield from (choose(key, name, allowed) for key, (name, allowed) in named.items() if name not in allowed)


def _system(config: Config) -> Iterator[str]:
    from repro.mechanics.system import load

    system = config.system
    try:
        load(system.name, config.reading.name, system.damping, system.damping_frame, **system.constants)
    except UserError as error:
        yield f"system: {error}"


def _closed_form(config: Config) -> Iterator[str]:
    if _without_fit(config) or not optimiser_class(config.optimiser["kind"]).linear_only:
        return
    name, kind, objective = config.optimiser["name"], config.model["kind"], config.objective
    if not _linear(config):
        basis = config.basis.name
        yield f"optimiser = {name}: needs model=lagrangian and a linear basis (t1, library), not {kind}, {basis}"
    if objective.kind != "inverse":
        yield f"optimiser = {name}: is linear in tau only, so it needs objective=inverse, not {objective.kind}"
    if objective.transform_weight:
        yield f"objective.transform_weight = {objective.transform_weight}: optimiser={name} fits linear terms only"


def _black_box(config: Config) -> Iterator[str]:
    if config.model["kind"] != "blackbox":
        return
    if config.objective.kind == "inverse":
        yield "objective.kind = 'inverse': model=blackbox predicts accelerations only; use objective=forward"
    if config.sequence.kind != "d_only":
        yield f"sequence.kind = {config.sequence.kind!r}: model=blackbox has no energies; use sequence=d_only"
    if config.energies.reading != "raw":
        yield f"energies.reading = {config.energies.reading!r}: model=blackbox has no energies; use energies=raw"


def _momentum_transform(config: Config) -> Iterator[str]:
    weight, hidden = config.objective.transform_weight, config.model.get("transform_hidden")
    if not _without_fit(config) and bool(weight) != (hidden is not None):
        yield (
            f"objective.transform_weight = {weight} and model.transform_hidden = {hidden}: "
            "Omega_tran needs both, or neither"
        )


def _l1(config: Config) -> Iterator[str]:
    weights = {key: getattr(config.objective, key) for key in ("l1_kinetic", "l1_potential")}
    suits = config.optimiser["kind"] == "adam" and _linear(config)
    if _without_fit(config) or suits or not any(weights.values()):
        return
    given = ", ".join(f"objective.{key} = {value}" for key, value in weights.items())
    yield f"{given}: act on coefficients under optimiser=adam and a linear basis"


def _free_motion_keeps_its_energy(config: Config) -> Iterator[str]:
    if not _without_fit(config) and config.sequence.kind in FREE_MOTION and any(config.system.damping):
        yield f"system.damping = {config.system.damping}: D_H keeps its energy only without damping"


def _recording(config: Config) -> Iterator[str]:
    if not isinstance(config.data, File):
        return
    if config.data.path == "???":
        yield "data.path: a value is needed: your CSV or Parquet file"
    elif not Path(config.data.path).is_file():
        yield f"data.path = {config.data.path!r}: no such file; give a CSV or Parquet file"
    if config.model["kind"] == "degenerate":
        yield "model.kind = 'degenerate': is made from the true system, which data=file does not tell"
    if config.sequence.kind != "d_only":
        yield f"sequence.kind = {config.sequence.kind!r}: needs simulated data; data=file goes with sequence=d_only"
    if config.curriculum.episodes:
        yield "curriculum.episodes: needs simulated data; data=file goes with curriculum=none"


RULES: tuple[Callable[[Config], Iterator[str]], ...] = (
    _system,
    _closed_form,
    _black_box,
    _momentum_transform,
    _l1,
    _free_motion_keeps_its_energy,
    _recording,
)


def _without_fit(config: Config) -> bool:
    return config.model["kind"] in ANCHOR_ROWS


def _linear(config: Config) -> bool:
    features = import_module(f"repro.models.bases.{config.basis.name}")
    return config.model["kind"] == "lagrangian" and features.LINEAR
