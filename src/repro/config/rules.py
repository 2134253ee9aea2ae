"""Settings that are right one by one and cannot go together: one small rule an idea."""

from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from repro.config.error_lines import choose
from repro.config.plugin_options import choices, optimiser_class
from repro.config.schema import Config, File
from repro.errors import UserError

if TYPE_CHECKING:
    from repro.mechanics.system import System

ANCHOR_ROWS = ("trivial", "degenerate", "truth")  # nothing is fitted
ON_A_DEVICE = ("lagrangian", "structured", "blackbox")  # computed by torch from end to end
FREE_MOTION = ("pretrain_only", "pretrain", "joint")
BASES = "repro.models.bases"


def impossible(config: Config) -> Iterator[str]:
    """What cannot be run, a line a reason; the names come first, for the rules look at what they name."""
    unknown = [*_unknown_names(config)]
    yield from unknown or (line for rule in RULES for line in rule(config))


def linear(config: Config) -> bool:
    """Whether the model is linear in its parameters."""
    return config.model["kind"] == "lagrangian" and _features(config.basis.name).LINEAR


def _linear_beside_parts(config: Config) -> bool:
    """Whether a model around trained sub-models is linear in what is fitted."""
    kind, frozen = config.model["kind"], config.model.get("frozen")
    of_basis = kind == "extended" and config.model["rest"] == "basis" and _features(config.basis.name).LINEAR
    return bool(frozen) and (kind == "hinged" or of_basis)


def _unknown_names(config: Config) -> Iterator[str]:
    named = {
        "system.name": (config.system.name, choices("repro.mechanics.systems")),
        "basis.name": (config.basis.name, choices(BASES)),
    }
    yield from (choose(key, name, allowed) for key, (name, allowed) in named.items() if name not in allowed)


def _system(config: Config) -> Iterator[str]:
    try:
        _load(config)
    except UserError as error:
        yield f"system: {error}"


def _basis_of_another_system(config: Config) -> Iterator[str]:
    needed = getattr(_features(config.basis.name), "N_Q", None)
    if config.model["kind"] != "lagrangian" or needed is None or [*_system(config)]:
        return
    n_q = _load(config).n_q
    if n_q != needed:
        general = ", ".join(name for name in choices(BASES) if not hasattr(_features(name), "N_Q"))
        yield (
            f"basis.name = {config.basis.name!r}: is made for {needed} coordinates, and "
            f"system={config.system.name} has {n_q}; use one of {general}"
        )


def _closed_form(config: Config) -> Iterator[str]:
    if _without_fit(config) or not optimiser_class(config.optimiser["kind"]).linear_only:
        return
    name, kind, objective = config.optimiser["name"], config.model["kind"], config.objective
    if not linear(config) and not _linear_beside_parts(config):
        basis, suited = config.basis.name, ", ".join(name for name in choices(BASES) if _features(name).LINEAR)
        yield f"optimiser = {name}: needs model=lagrangian and a linear basis ({suited}), not {kind}, {basis}"
    if objective.kind != "inverse":
        yield f"optimiser = {name}: is linear in tau only, so it needs objective=inverse, not {objective.kind}"
    if objective.momentum_weight:
        yield f"objective.momentum_weight = {objective.momentum_weight}: optimiser={name} fits linear terms only"


def _black_box(config: Config) -> Iterator[str]:
    if config.model["kind"] != "blackbox":
        return
    if config.objective.kind == "inverse":
        yield "objective.kind = 'inverse': model=blackbox predicts accelerations only; use objective=forward"
    if config.sequence.kind != "main":
        yield f"sequence.kind = {config.sequence.kind!r}: model=blackbox has no energies; use sequence=main"
    if config.energies.gauge != "raw":
        yield f"energies.gauge = {config.energies.gauge!r}: model=blackbox has no energies; use energies=raw"


def _port(config: Config) -> Iterator[str]:
    if config.objective.kind == "port" and config.model["kind"] != "port_hamiltonian":
        yield f"objective.kind = 'port': asks for eq. (12b) of model=port_hamiltonian, not of {config.model['kind']}"


def _momentum_transform(config: Config) -> Iterator[str]:
    weight, hidden = config.objective.momentum_weight, config.model.get("momentum_hidden")
    if not _without_fit(config) and bool(weight) != (hidden is not None):
        yield (
            f"objective.momentum_weight = {weight} and model.momentum_hidden = {hidden}: "
            "Omega_tran needs both, or neither"
        )


def _device(config: Config) -> Iterator[str]:
    model, optimiser, said = config.model, config.optimiser, f"device = {config.device!r}"
    if config.device == "cpu" or _without_fit(config):
        return
    if optimiser["kind"] != "adam":
        yield f"{said}: runs optimiser=adam or adam_cosine, not {optimiser['name']}; use device=cpu"
    if model["kind"] not in ON_A_DEVICE or model.get("factor") == "triangular":
        kind = "model.factor=triangular" if model.get("factor") == "triangular" else f"model={model['kind']}"
        yield f"{said}: runs model={', '.join(ON_A_DEVICE)}, not {kind}; use device=cpu"


def _l1(config: Config) -> Iterator[str]:
    weights = {key: getattr(config.objective, key) for key in ("l1_kinetic", "l1_potential")}
    suits = config.optimiser["kind"] == "adam" and linear(config)
    if _without_fit(config) or suits or not any(weights.values()):
        return
    given = ", ".join(f"objective.{key} = {value}" for key, value in weights.items())
    yield f"{given}: act on coefficients under optimiser=adam and a linear basis"


def _free_motion_keeps_its_energy(config: Config) -> Iterator[str]:
    if not _without_fit(config) and config.sequence.kind in FREE_MOTION and any(config.system.damping):
        yield f"system.damping = {config.system.damping}: D_H keeps its energy only without damping"


def _pretraining_epochs(config: Config) -> Iterator[str]:
    epochs, kind = config.sequence.pretraining_epochs, config.sequence.kind
    if epochs is None or _without_fit(config):
        return
    if kind not in ("pretrain_only", "pretrain"):
        yield f"sequence.pretraining_epochs = {epochs}: sequence={kind} has no phase on D_H alone; leave it at null"
    if "epochs" not in config.optimiser:
        name = config.optimiser["name"]
        yield f"sequence.pretraining_epochs = {epochs}: optimiser={name} does not count in epochs; leave it at null"


def _finish(config: Config) -> Iterator[str]:
    share, scale = config.objective.equal_weight_share, config.objective.error_scale
    if not _without_fit(config) and share and scale is None:
        yield (
            f"objective.equal_weight_share = {share}: equal weights at the end need other weights before: "
            "objective.error_scale"
        )


def _triangular_factor(config: Config) -> Iterator[str]:
    rank = config.model.get("rank")
    if rank is not None and config.model.get("factor") == "triangular":
        yield f"model.rank = {rank}: a triangular factor has as many columns as coordinates; use model.factor=wide"


def _chain(config: Config) -> Iterator[str]:
    learned = ("lagrangian", "neural_potential", "port_hamiltonian")
    if config.chain and (config.system.name != "link" or config.model["kind"] not in learned):
        yield f"chain = {config.chain}: joins copies of a link that system=link and model={learned[0]} have learned"
    if config.whole_chain and (config.system.name != "link" or isinstance(config.data, File)):
        yield f"whole_chain = {config.whole_chain}: is sampled from the true chain; use system=link, not data=file"


def _recording(config: Config) -> Iterator[str]:
    if not isinstance(config.data, File):
        return
    if config.data.path == "???":
        yield "data.path: a value is needed: your CSV or Parquet file"
    elif not Path(config.data.path).is_file():
        yield f"data.path = {config.data.path!r}: no such file; give a CSV or Parquet file"
    if config.model["kind"] == "degenerate":
        yield "model.kind = 'degenerate': is made from the true system, which data=file does not tell"
    if config.sequence.kind != "main":
        yield f"sequence.kind = {config.sequence.kind!r}: needs simulated data; data=file goes with sequence=main"
    if config.curriculum.episodes:
        yield "curriculum.episodes: needs simulated data; data=file goes with curriculum=none"


def _closed_loop(config: Config) -> Iterator[str]:
    control, task, kind = config.control, config.task, config.model["kind"]
    if control.kind == "none" or [*_system(config)]:
        return
    said = f"control = {control.name!r}"
    if isinstance(config.data, File):
        yield f"{said}: drives the true system, which data=file does not tell; use control=none"
    if kind in ("trivial", "degenerate", "blackbox"):
        yield f"{said}: needs a model with energies and an invertible mass matrix, not model={kind}"
    system = _load(config)
    if control.kind == "energy_shaping" and system.n_q != 2:
        yield f"{said}: swings up one link, and system={config.system.name} has {system.n_q - 1}"
    if task.delay >= control.time_step:
        yield f"task.delay = {task.delay}: must be shorter than control.time_step = {control.time_step}"
    if len(task.damping) not in (0, system.n_q):
        yield f"task.damping = {task.damping}: needs {system.n_q} numbers, or none"


RULES: tuple[Callable[[Config], Iterator[str]], ...] = (
    _system,
    _basis_of_another_system,
    _closed_form,
    _black_box,
    _port,
    _momentum_transform,
    _device,
    _l1,
    _free_motion_keeps_its_energy,
    _pretraining_epochs,
    _chain,
    _finish,
    _triangular_factor,
    _recording,
    _closed_loop,
)


def _without_fit(config: Config) -> bool:
    return config.model["kind"] in ANCHOR_ROWS


def _load(config: Config) -> "System":
    from repro.mechanics.system import load

    system = config.system
    return load(
        system.name,
        config.reading.name,
        system.damping,
        system.damping_frame,
        system.damping_growth,
        **system.constants,
    )


def _features(basis: str) -> ModuleType:
    return import_module(f"{BASES}.{basis}")
