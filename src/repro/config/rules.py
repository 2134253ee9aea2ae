"""Settings that are right one by one and cannot go together: one small rule an idea."""

from collections.abc import Callable, Iterator
from types import ModuleType

from repro.config.data_rules import recording, sensors, without_accelerations, wrong_content
from repro.config.schema import Config, coordinates_of, true_system
from repro.config.submodels import is_settings, n_coordinates, settings_of
from repro.control.controller import ControllerOptions
from repro.data.data_options import RandomForce, RecordingFile
from repro.errors import UserError
from repro.models.gauge import Gauge
from repro.models.model_options import MODELS
from repro.plugins.plugin import not_allowed, plugin, plugin_names

BASES, SYSTEMS = "models.bases", "mechanics.systems"


def impossible(config: Config) -> Iterator[str]:
    """Reasons why this configuration cannot run, one line each; unknown names and systems first, as rules load them."""
    rules = (*RULES, *FITTED_RULES) if config.model.fitted else RULES
    lines = [*_unknown_names(config)] or [*_system(config)] or [line for rule in rules for line in rule(config)]
    yield from lines or wrong_content(config)


def linear(config: Config) -> bool:
    """Whether the weights of the model are the coefficients of a linear basis."""
    return config.model.has_coefficients and _features(config.basis.name).LINEAR


def _unknown_names(config: Config) -> Iterator[str]:
    for key, name, folder in (("system", config.system.name, SYSTEMS), ("basis", config.basis.name, BASES)):
        if name not in plugin_names(folder):
            yield not_allowed(f"{key}.name", name, plugin_names(folder))


def _system(config: Config) -> Iterator[str]:
    try:
        system = true_system(config)
        if isinstance(config.data, RandomForce):
            system.at_rest(config.data.start)
    except UserError as error:
        yield f"system: {error}"


def _basis_of_another_system(config: Config) -> Iterator[str]:
    if not config.model.uses_basis or [*recording(config)]:
        return
    units = [coordinate.unit for coordinate in coordinates_of(config)]
    if not _suits(config.basis.name, units):
        suited = ", ".join(name for name in plugin_names(BASES) if _suits(name, units))
        needed = ", ".join("..." if unit is ... else unit for unit in _features(config.basis.name).COORDINATES)
        owner = "data.coordinates" if config.own_coordinates else f"system={config.system.name}"
        yield (
            f"basis.name = {config.basis.name!r}: is made for coordinates in {needed}, and "
            f"{owner} has {', '.join(units)}; use one of {suited}"
        )


def _suits(basis: str, units: list[str]) -> bool:
    needed = list(getattr(_features(basis), "COORDINATES", units))
    if needed[-1] is ...:
        needed = needed[:-1] + needed[-2:-1] * (len(units) - len(needed) + 1)
    return units == needed


def _closed_form(config: Config) -> Iterator[str]:
    if not config.optimiser.linear_only:
        return
    name, kind, objective = config.optimiser.name, config.model.kind, config.objective
    if not config.model.is_linear(_features(config.basis.name).LINEAR):
        basis, suited = config.basis.name, ", ".join(name for name in plugin_names(BASES) if _features(name).LINEAR)
        yield f"optimiser = {name}: needs model=lagrangian and a linear basis ({suited}), not {kind}, {basis}"
    if not objective.linear:
        suited = "implicit" if config.model.implicit_form else "inverse or balance"
        yield f"optimiser = {name}: is linear in tau only; use objective={suited}, not {objective.kind}"
    if objective.momentum_weight:
        yield f"objective.momentum_weight = {objective.momentum_weight}: optimiser={name} fits linear terms only"


def _without_energies(config: Config) -> Iterator[str]:
    if config.model.energetic:
        return
    choice = f"model={config.model.kind}"
    if config.objective.needs_energies and not config.objective.needs_port_form:
        own = ("port", config.model.port_form), ("implicit", config.model.implicit_form)
        suited = next((kind for kind, fits in own if fits), "forward")
        kind = config.objective.kind
        yield f"objective.kind = '{kind}': {choice} predicts accelerations only; use objective={suited}"
    if config.sequence.needs_energies:
        yield f"sequence.kind = '{config.sequence.kind}': {choice} has no energies; use sequence=main"
    if config.energies.gauge is not Gauge.RAW:
        yield f"energies.gauge = '{config.energies.gauge}': {choice} has no energies; use energies=raw"


def _start_of_coefficients(config: Config) -> Iterator[str]:
    if config.model.draws_coefficients and not linear(config):
        yield (
            "model.initialisation: this start is one of the coefficients of a linear basis, and "
            f"basis={config.basis.name} feeds a network; choose glorot or wide, or a linear basis such as basis=t1"
        )


def _device(config: Config) -> Iterator[str]:
    choice = f"device = {config.device!r}"
    if config.device == "cpu":
        return
    if not config.optimiser.runs_on_device:
        yield f"{choice}: runs optimiser=adam or adam_cosine, not {config.optimiser.name}; use device=cpu"
    if getattr(config.optimiser, "budget_s", None) is not None:
        yield f"{choice}: counts epochs, not CPU seconds; leave optimiser.budget_s at null"
    if problem := config.model.device_problem():
        yield f"{choice}: runs model={', '.join(_models_with('runs_on_device'))}, not {problem}; use device=cpu"


def _objective(config: Config) -> Iterator[str]:
    """What a loss needs of the model and of the optimiser, and its weights of each other."""
    objective, model, choice = config.objective, config.model, f"objective.kind = {config.objective.kind!r}"
    for needed in ("differentiable", "implicit_form", "port_form"):
        if getattr(objective, f"needs_{needed}") and not getattr(model, needed):
            yield f"{choice}: needs model={', '.join(_models_with(needed))}, not model={model.kind}"
    if config.optimiser.linearises and not objective.linearised:
        yield f"{choice}: has no Jacobian; use optimiser=adam, adam_budget or lbfgs, not {config.optimiser.name}"
    if bool(objective.momentum_weight) != model.has_momentum_transform:
        hidden = "set" if model.has_momentum_transform else "null"
        yield (
            f"objective.momentum_weight = {objective.momentum_weight} and model.momentum_hidden is {hidden}: "
            "Omega_tran needs both, or neither"
        )
    weights = {key: getattr(objective, key) for key in ("l1_kinetic", "l1_potential")}
    if any(weights.values()) and not (config.optimiser.handles_l1 and linear(config)):
        weighted = ", ".join(f"objective.{key} = {value}" for key, value in weights.items())
        yield f"{weighted}: act on coefficients under optimiser=adam and a linear basis"
    if objective.equal_weight_share and objective.error_scale is None:
        yield (
            f"objective.equal_weight_share = {objective.equal_weight_share}: equal weights at the end need other "
            "weights before: objective.error_scale"
        )


def _sequence(config: Config) -> Iterator[str]:
    """Data without force: they keep their energy, and epochs on them alone need a phase and an optimiser for it."""
    sequence, optimiser = config.sequence, config.optimiser
    for name, values in (("damping", config.system.damping), ("coulomb", config.system.coulomb)):
        if sequence.uses_free_motion and any(values):
            yield f"system.{name} = {values}: D_H keeps its energy only without friction"
    choice = f"sequence.pretraining_epochs = {sequence.pretraining_epochs}"
    if sequence.pretraining_epochs is not None and not sequence.begins_with_free_motion:
        yield f"{choice}: sequence={sequence.kind} has no phase on D_H alone; leave it at null"
    if sequence.pretraining_epochs is not None and optimiser.unit != "epochs":
        yield f"{choice}: optimiser={optimiser.name} does not count in epochs; leave it at null"


def _model_of_system(config: Config) -> Iterator[str]:
    if isinstance(config.data, RecordingFile) or [*_closed_loop(config)]:
        return
    if problem := config.model.system_problem(true_system(config)):
        yield problem


def _parts(config: Config) -> Iterator[str]:
    if not config.model.sub_models or isinstance(config.data, RecordingFile):
        return
    for part in filter(is_settings, config.model.sub_models):
        yield from impossible(settings_of(part, config))
    sizes = [n_coordinates(part, config) for part in config.model.sub_models]
    if problem := config.model.parts_problem(true_system(config).n_q, sizes):
        yield problem


def _chain(config: Config) -> Iterator[str]:
    if config.chain and (config.system.name != "link" or not config.model.joinable or config.own_coordinates):
        suited = ", ".join(_models_with("joinable"))
        yield f"chain = {config.chain}: joins copies of a link; use system=link and one of model={suited}"
    if config.whole_chain and (config.system.name != "link" or isinstance(config.data, RecordingFile)):
        yield f"whole_chain = {config.whole_chain}: is sampled from the true chain; use system=link, not data=file"


def _closed_loop(config: Config) -> Iterator[str]:
    from repro.mechanics.chain import Chain
    from repro.mechanics.system import load

    control, task = config.control, config.task
    if not isinstance(control, ControllerOptions):
        return
    choice = f"control = {control.name!r}"
    if isinstance(config.data, RecordingFile):
        yield f"{choice}: drives the true system, which data=file does not include; use control=none"
    if not config.model.controllable:
        yield f"{choice}: needs a model with energies and an invertible mass matrix, not model={config.model.kind}"
    system = true_system(config)
    if not control.fits(system):
        count, names = len(system.inputs), ", ".join(coordinate.name for coordinate in system.coordinates)
        own = f"system={system.name} has {count} input{'s' * (count > 1)} and coordinates {names}"
        suited = ", ".join(name for name in plugin_names(SYSTEMS) if control.fits(load(name)))
        yield f"{choice}: drives {control.drives}; {own}; use system={suited}"
    yield from control.problems(system)
    yield from task.problems(system, control)
    if config.model.from_true_system and not isinstance(system, Chain):
        exact = f"model={config.model.kind}: has no coefficients for system={system.name}"
        if task.mismatch and task.mismatch_kind == "coefficients":
            yield f"task.mismatch = {task.mismatch}: {exact}; use task.mismatch_kind=physical"
        if control.adapts:
            yield f"control.adaptive = True: {exact}; use a fitted model, such as model=structured"


Rules = tuple[Callable[[Config], Iterator[str]], ...]
RULES: Rules = (
    _basis_of_another_system,
    _without_energies,
    _start_of_coefficients,
    _chain,
    lambda config: config.model.problems(),
    _model_of_system,
    _parts,
    sensors,
    recording,
    _closed_loop,
)
# Of a model with weights to fit.
FITTED_RULES: Rules = (_closed_form, _objective, _sequence, _device, without_accelerations)


def _models_with(capability: str) -> list[str]:
    """Kinds of model whose options declare a capability."""
    return [kind for kind in plugin_names(MODELS) if getattr(plugin(MODELS, kind).Options, capability)]


def _features(basis: str) -> ModuleType:
    return plugin(BASES, basis)
