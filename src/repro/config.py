"""The schema of a run: every key, its type and what is allowed, checked before anything is computed."""

import difflib
import importlib
import inspect
import math
import pkgutil
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, create_model

from repro.errors import UserError

Count = Annotated[int, Field(gt=0)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Share = Annotated[float, Field(gt=0, lt=1)]


class Section(BaseModel):
    """A group of keys; a key that is not listed is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class System(Section):
    """The true system (conf/system)."""

    name: str
    damping: list[NotNegative]
    damping_frame: Literal["relative", "absolute"]


class Reading(Section):
    """Which reading of the paper's conventions (conf/reading)."""

    name: Literal["physical", "printed"]


class RandomForce(Section):
    """Simulated data D (conf/data)."""

    source: Literal["random_force"]
    regime: Literal["episodes", "long"]
    episode_steps: Count
    samples: Annotated[int, Field(ge=10)]
    train_fraction: Share
    time_step: Positive
    force_limit: Positive
    start: Literal["upright", "hanging"]
    reset: Literal["start", "random"]
    labels: Literal["exact", "differenced"]
    tau_noise: NotNegative
    qdd_noise: NotNegative
    q_noise: NotNegative
    qd_noise: NotNegative
    shared: bool


class Columns(Section):
    """Names of the columns of a recording."""

    q: list[str]
    qd: list[str]
    tau: list[str]
    qdd: list[str] = []
    time: list[str] = []
    episode: list[str] = []


class File(Section):
    """One's own recording (conf/data/file)."""

    source: Literal["file"]
    path: str
    columns: Columns
    time_step: Positive | None
    train_fraction: Share


class Curriculum(Section):
    """Earlier training phases on shorter episodes (conf/curriculum)."""

    episodes: list[Count]
    samples: Annotated[int, Field(ge=10)]


class Basis(Section):
    """Features of T and V (conf/basis): a file of repro/models/bases."""

    name: str


class Objective(Section):
    """The loss (conf/objective)."""

    kind: Literal["inverse", "forward"]
    transform_weight: NotNegative
    l1_kinetic: NotNegative
    l1_potential: NotNegative
    error_scale: Positive | None


class Sequence(Section):
    """Which data in which order (conf/sequence)."""

    kind: Literal["d_only", "anchor", "d_h_only", "d_h_then_d", "joint"]
    energy_weight: Positive
    energy_form: Literal["legendre", "sum"]
    starts: Annotated[int, Field(ge=2)]
    steps: Annotated[int, Field(ge=1)]


class Energies(Section):
    """How T and V are read off a fitted model (conf/energies)."""

    reading: Literal["raw", "anchor", "canonical", "canonical_anchor"]


class Scale(Section):
    """How much of an experiment is run (conf/scale)."""

    name: Literal["smoke", "quick", "paper"]
    samples: Annotated[int, Field(ge=10)]
    seeds: Count
    epochs: Annotated[float, Field(gt=0, le=1)]
    iterations: Annotated[float, Field(gt=0, le=1)]


class Config(Section):
    """One run. `model` and `optimiser` are checked against the files that their `kind` names."""

    system: System
    reading: Reading
    data: Annotated[RandomForce | File, Field(discriminator="source")]
    curriculum: Curriculum
    model: dict[str, Any]
    basis: Basis
    objective: Objective
    optimiser: dict[str, Any]
    sequence: Sequence
    energies: Energies
    scale: Scale
    seeds: Annotated[int, Field(gt=0)] | Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1)] | None
    record: bool
    experiment: str | None
    sweep: list[str]

    @property
    def members(self) -> list[int]:
        """The seeds, one a member."""
        count = self.scale.seeds if self.seeds is None else self.seeds
        return list(range(count)) if isinstance(count, int) else list(count)


def parse(raw: Mapping[str, Any]) -> Config:
    """Check a composed configuration; UserError with one line per mistake: key, value, and what is allowed."""
    try:
        config = Config.model_validate(raw)
    except ValidationError as error:
        raise UserError("\n".join(_lines(error, raw))) from None
    options = model_options(config.model)
    settings = optimiser_options(config.optimiser)
    config = config.model_copy(update={"model": options, "optimiser": settings})
    if problems := list(_impossible(config)):
        raise UserError("\n".join(problems))
    return config


def scaled(config: Config) -> Config:
    """The same run at its scale: samples capped, epochs and iterations shortened."""
    scale = config.scale
    optimiser = dict(config.optimiser)
    for key, share in (("epochs", scale.epochs), ("iterations", scale.iterations), ("scouting", scale.iterations)):
        if key in optimiser:
            optimiser[key] = max(1, math.ceil(optimiser[key] * share))
    updates: dict[str, Any] = {"optimiser": optimiser}
    if isinstance(config.data, RandomForce):
        updates["data"] = config.data.model_copy(update={"samples": min(config.data.samples, scale.samples)})
        shorter = min(config.curriculum.samples, scale.samples)
        updates["curriculum"] = config.curriculum.model_copy(update={"samples": shorter})
    return config.model_copy(update=updates)


def choices(package: str) -> list[str]:
    """Names of the files of a package, e.g. repro.models.bases."""
    folder = importlib.import_module(package).__path__
    return sorted(module.name for module in pkgutil.iter_modules(folder))


def optimiser_class(kind: str) -> type:
    """The optimiser that the file repro/learning/<kind>.py holds."""
    from repro.learning.optimiser import Optimiser

    module = importlib.import_module(f"repro.learning.{kind}")
    (found,) = (
        member
        for member in vars(module).values()
        if inspect.isclass(member) and issubclass(member, Optimiser) and member.__module__ == module.__name__
    )
    return found


def model_options(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Check conf/model against the keywords of `build` in the file that `kind` names."""
    kind = _kind(raw, "model", "repro.models", "build")
    build = importlib.import_module(f"repro.models.{kind}").build
    hints = get_type_hints(build)
    parameters = [p for p in inspect.signature(build).parameters.values() if p.kind is p.KEYWORD_ONLY]
    fields = {p.name: (hints[p.name], ... if p.default is p.empty else p.default) for p in parameters}
    schema = create_model("model", __base__=Section, kind=(str, ...), **fields)
    return _checked(schema, "model", raw)


def optimiser_options(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Check conf/optimiser against the fields of the optimiser in the file that `kind` names."""
    kind = _kind(raw, "optimiser", "repro.learning", "Optimiser")
    found = optimiser_class(kind)
    hints = get_type_hints(found)
    fields = {field.name: (hints[field.name], field.default) for field in found.__dataclass_fields__.values()}
    schema = create_model("optimiser", __base__=Section, name=(str, ...), kind=(str, ...), **fields)
    checked = _checked(schema, "optimiser", raw)
    for key, value in checked.items():
        if isinstance(value, (int, float)) and not isinstance(value, bool) and value < 0:
            raise UserError(f"optimiser.{key} = {value}: must not be negative")
        if key in ("epochs", "iterations", "batch_size", "samples", "starts", "curve_points") and value == 0:
            raise UserError(f"optimiser.{key} = 0: must be at least 1")
    return checked


def _kind(raw: Mapping[str, Any], group: str, package: str, holds: str) -> str:
    kind, allowed = raw.get("kind"), [n for n in choices(package) if _holds(f"{package}.{n}", holds)]
    if kind not in allowed:
        raise UserError(f"{group}.kind = {kind!r}: allowed are {', '.join(allowed)}{_meant(str(kind), allowed)}")
    return str(kind)


def _holds(module: str, name: str) -> bool:
    source = inspect.getsource(importlib.import_module(module))
    return f"\ndef {name}(" in source or f"({name}):\n" in source


def _checked(schema: type[BaseModel], group: str, raw: Mapping[str, Any]) -> dict[str, Any]:
    try:
        return TypeAdapter(schema).validate_python(dict(raw)).model_dump()
    except ValidationError as error:
        raise UserError("\n".join(_lines(error, raw, group))) from None


def _lines(error: ValidationError, raw: Mapping[str, Any], prefix: str = "") -> Iterable[str]:
    for problem in error.errors():
        path = [str(part) for part in problem["loc"] if part not in ("random_force", "file")]
        key = ".".join([prefix, *path] if prefix else path)
        if problem["type"] == "extra_forbidden":
            allowed = _siblings(error, raw, problem, prefix)
            yield f"{key}: unknown key{_meant(path[-1], allowed)}" + (
                f"; allowed are {', '.join(allowed)}" if allowed else ""
            )
        elif problem["type"] == "missing":
            yield f"{key}: a value is needed"
        else:
            message = problem["msg"].removeprefix("Input ").removeprefix("Value error, ")
            yield f"{key} = {problem['input']!r}: {message}"


def _siblings(error: ValidationError, raw: Mapping[str, Any], problem: Any, prefix: str) -> list[str]:
    section: Any = raw
    for part in problem["loc"][:-1]:
        section = section.get(part, section) if isinstance(section, Mapping) else {}
    unknown = {p["loc"][-1] for p in error.errors() if p["type"] == "extra_forbidden"}
    return sorted(str(key) for key in section if key not in unknown)


def _meant(word: str, allowed: Iterable[str]) -> str:
    close = difflib.get_close_matches(word, list(allowed), n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def _impossible(config: Config) -> Iterable[str]:
    from repro.models.blackbox import BlackBox

    kind, basis, objective, optimiser = (
        config.model["kind"], config.basis.name, config.objective, config.optimiser["name"],
    )  # fmt: skip
    bases, systems = choices("repro.models.bases"), choices("repro.mechanics.systems")
    if basis not in bases:
        yield f"basis.name = {basis!r}: allowed are {', '.join(bases)}{_meant(basis, bases)}"
        return
    if config.system.name not in systems:
        allowed = ", ".join(systems)
        yield f"system.name = {config.system.name!r}: allowed are {allowed}{_meant(config.system.name, systems)}"
        return
    seeds = config.members
    if len(set(seeds)) != len(seeds):
        yield f"seeds = {seeds}: a seed is given twice, so two members would be the same; give each once"
    linear = importlib.import_module(f"repro.models.bases.{basis}").LINEAR and kind == "lagrangian"
    if kind in ("trivial", "degenerate"):
        return
    if optimiser_class(config.optimiser["kind"]).linear_only:
        if not linear:
            yield f"optimiser = {optimiser}: needs model=lagrangian and a linear basis (t1, library), not {kind}, {basis}"
        if objective.kind != "inverse":
            yield f"optimiser = {optimiser}: is linear in tau only, so it needs objective=inverse, not {objective.kind}"
        if objective.transform_weight:
            yield f"objective.transform_weight = {objective.transform_weight}: optimiser={optimiser} fits linear terms only"
    if kind == "blackbox":
        if objective.kind == "inverse" and not BlackBox.inverse:
            yield "objective.kind = 'inverse': model=blackbox predicts accelerations only; use objective=forward"
        if config.sequence.kind != "d_only":
            yield f"sequence.kind = {config.sequence.kind!r}: model=blackbox has no energies; use sequence=d_only"
        if config.energies.reading != "raw":
            yield f"energies.reading = {config.energies.reading!r}: model=blackbox has no energies; use energies=raw"
    if bool(objective.transform_weight) != (config.model.get("transform_hidden") is not None):
        yield (
            f"objective.transform_weight = {objective.transform_weight} and model.transform_hidden = "
            f"{config.model.get('transform_hidden')}: Omega_tran needs both, or neither"
        )
    if (objective.l1_kinetic or objective.l1_potential) and (config.optimiser["kind"] != "adam" or not linear):
        yield "objective.l1_kinetic, objective.l1_potential: act on coefficients under optimiser=adam and a linear basis"
    if config.sequence.kind in ("d_h_only", "d_h_then_d", "joint") and any(config.system.damping):
        yield f"system.damping = {config.system.damping}: D_H keeps its energy only without damping"
    if isinstance(config.data, File):
        if config.sequence.kind != "d_only":
            yield f"sequence.kind = {config.sequence.kind!r}: needs simulated data; data=file goes with sequence=d_only"
        if config.curriculum.episodes:
            yield "curriculum.episodes: needs simulated data; data=file goes with curriculum=none"
