"""The typed options of a choice, by its name: what the command line reads from conf/ and Python code from here."""

from collections.abc import Sequence
from typing import Any

from repro.control.controller import ControllerOptions
from repro.control.task import Task
from repro.errors import UserError
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.optimiser_options import OptimiserOptions
from repro.mechanics.system import System, load_system
from repro.mechanics.system_options import SystemOptions
from repro.models.model_options import ModelOptions
from repro.plugins.checked import validated
from repro.plugins.plugin import plugin


def model(name: str, **options: Any) -> ModelOptions:
    """Options of a model (a file of models/kinds); UserError for what it does not have, or does not allow."""
    chosen = _checked("models.kinds", name, options)
    assert isinstance(chosen, ModelOptions)
    if problem := next(chosen.problems(), None):
        raise UserError(problem)
    return chosen


def optimiser(name: str, **options: Any) -> OptimiserOptions:
    """Options of an optimiser (a file of learning/optimisers); UserError as for `model`."""
    chosen = _checked("learning.optimisers", name, options)
    assert isinstance(chosen, OptimiserOptions)
    return chosen


def controller(name: str, **options: Any) -> ControllerOptions:
    """Options of a controller (a file of control/controllers); UserError as for `model`."""
    chosen = _checked("control.controllers", name, options)
    assert isinstance(chosen, ControllerOptions)
    return chosen


def task(start: str = "hanging", **options: Any) -> Task:
    """Where closed loops start and go, options as in conf/task; UserError as for `model`.

    Examples
    --------
    >>> import repro
    >>> repro.task(initial_states=10, x_des=[0.5], noise=1.0).initial_states
    10
    """
    chosen: Task = validated(Task, "task", {"name": "", "start": start, **options})
    return chosen


def objective(name: str, **options: Any) -> ObjectiveOptions:
    """Options of an objective (`inverse`, `forward`, `port`, ...); UserError as for `model`."""
    chosen: ObjectiveOptions = validated(ObjectiveOptions, f"objective {name}", {"kind": name, **options})
    return chosen


def system(name: str, *, damping: Sequence[float] = (), reading: str = "physical", **constants: float) -> System:
    """A mechanical system (a file of mechanics/systems) with its constants; UserError for one that it does not have."""
    options = {"name": name, "reading": reading, "damping": damping, "constants": constants}
    return load_system(validated(SystemOptions, name, options))


def _checked(folder: str, name: str, options: dict[str, Any]) -> object:
    return validated(plugin(folder, name).Options, name, options)
