"""What the rules accept can be run: every system, model, basis, objective and controller, each for one step."""

import itertools
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from configurations import changed

from repro.codegen import c_library
from repro.config.registry import groups, settings
from repro.config.schema import Config
from repro.control.controller import CONTROLLERS, ControllerOptions
from repro.control.predictive_model import PredictiveModel
from repro.errors import UserError
from repro.mechanics import simulate as engines
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.pipeline.stages.stored_fit import load_parameters, model_of, simulated_system
from repro.plugins.checked import checked
from repro.plugins.plugin import plugin
from repro.tracking.store import Store

SMALL = (
    *("scale=smoke", "seeds=1", "record=false", "data.samples=60", "data.episode_steps=20", "data.reset=random"),
    *("optimiser=lbfgs", "optimiser.iterations=1"),
)
OBJECTIVES, TASKS = groups()["objective"], groups()["task"]
PAIRS = [*itertools.product(groups()["system"], groups()["model"])]
# The paper's system with every model, every system with the general model and two anchor rows; the others are slow.
QUICK = {pair for pair in PAIRS if pair[0] == "sip" or pair[1] in ("structured", "truth", "degenerate")}
MARKED = [pair if pair in QUICK else pytest.param(*pair, marks=pytest.mark.slow) for pair in PAIRS]


@pytest.fixture(autouse=True)
def _without_compiler(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A step costs less than the compilation of its code, and compiled code has tests of its own."""
    monkeypatch.setattr(c_library, "found_compiler", lambda: None)
    caches = engines.active_engine, engines.compiled, c_library._version  # a known version means a compiler
    for cache in caches:
        cache.cache_clear()
    yield
    for cache in caches:
        cache.cache_clear()


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """One store for all, so that the data of a system are made once."""
    return Store(Path(tmp_path_factory.mktemp("combinations")))


def _accepted(system: str, model: str, **others: str) -> Config | None:
    sizes = {"hidden": [2], "potential_hidden": [2]}
    chosen = {key: sizes[key] if key in sizes and value else value for key, value in settings("model", model).items()}
    try:
        return changed(SMALL, system=system, model=chosen, **others)
    except UserError:
        return None


def _learned(system: str, model: str) -> Iterator[tuple[dict[str, str], Pipeline]]:
    """The accepted choices of basis and objective; of the bases only those that make a difference to a model."""
    bases = groups()["basis"] if model == "lagrangian" else ["t2"]
    for basis, objective in itertools.product(bases, OBJECTIVES):
        choices = {"basis": basis, "objective": objective}
        if (config := _accepted(system, model, **choices)) is not None:
            yield choices, Pipeline.of(config, "")


def _controllers(system: str, model: str, **others: str) -> Iterator[Config]:
    """The accepted choices of conf/control, each with the first task that suits it; one of those alike but in sizes."""
    seen = []
    for control in groups()["control"]:
        accepted = (_accepted(system, model, control=control, task=task, **others) for task in TASKS)
        config = next((each for each in accepted if each is not None), None)
        if config is not None and isinstance(config.control, ControllerOptions):
            options = config.control.plain()
            choices = [value for key, value in options.items() if isinstance(value, str | bool) and key != "name"]
            weighted = [bool(options.get("stage_cost", {}).get(term)) for term in ("kinetic", "potential", "angle")]
            if [choices, weighted] not in seen:
                seen.append([choices, weighted])
                yield config


@pytest.mark.parametrize(("system", "model"), MARKED)
def test_an_accepted_pair_of_system_and_model_runs(system, model, store):
    """With the first basis and objective that are accepted."""
    _, pipeline = next(_learned(system, model), ({}, None))
    if pipeline is not None:
        assert execute(pipeline, store).summary["median"]


@pytest.mark.slow
@pytest.mark.parametrize(("system", "model"), PAIRS)
def test_every_accepted_basis_and_objective_runs(system, model, store):
    failed = []
    for choices, pipeline in _learned(system, model):
        try:
            execute(pipeline, store)
        except Exception as error:
            failed.append(f"{choices}: {type(error).__name__} {error}")
    assert not failed, "\n".join(failed)


@pytest.mark.slow
@pytest.mark.parametrize(("system", "model"), PAIRS)
def test_every_accepted_controller_decides(system, model, store):
    """One step over a horizon of two or three intervals, with the weights of one iteration."""
    of_bases = {choices["basis"]: choices for choices, _ in _learned(system, model)}
    failed = []
    for choices in of_bases.values():
        for config in _controllers(system, model, **choices):
            try:
                _decide(config, store)
            except Exception as error:
                failed.append(f"{choices} control={config.control.name}: {type(error).__name__} {error}")
    assert not failed, "\n".join(failed)


def _decide(config: Config, store: Store) -> None:
    pipeline = Pipeline.of(config.model_copy(update={"control": checked("control", CONTROLLERS, {"kind": "none"})}), "")
    fit = execute(pipeline, store).upstream["fit"]
    system, options = simulated_system(pipeline.fit_options), config.control
    if hasattr(options, "intervals"):
        options = replace(options, intervals=2, coarse_intervals=min(1, options.coarse_intervals), iterations=2)
    (start, _), *_ = config.task.starts(system, 1)
    model = PredictiveModel(model_of(pipeline.fit_options, fit.upstream), system)
    samples = tuple(np.random.default_rng(0).normal(size=(3, 20, system.n_q)))
    with plugin(CONTROLLERS, options.kind).build(options, model, config.task.disc(system), samples) as make:
        controller = make(np.asarray(load_parameters(fit.folder))[0], start.goal)
        step = controller.decide(start.state)
        assert step.u.shape == (len(system.inputs),) and np.all(np.abs(step.u) <= options.limits(system))
        controller.observe(np.tile(start.state, (9, 1)), np.tile(step.u, (8, 1)))
