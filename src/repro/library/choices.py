"""The typed options of a choice, by its name: what the command line reads from conf/ and Python code from here."""

from collections.abc import Sequence
from typing import Any, TypeVar

from repro.control.controller import CONTROLLERS, ControllerOptions
from repro.control.task import Task
from repro.errors import UserError
from repro.evaluation.metric_options import METRICS, MetricOptions
from repro.learning.objective_options import OBJECTIVES, ObjectiveOptions
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.sequence_options import SEQUENCES, SequenceOptions
from repro.mechanics.system import System, load_system
from repro.mechanics.system_options import SystemOptions
from repro.models.model_options import ModelOptions
from repro.plugins.checked import validated
from repro.plugins.plugin import plugin

Chosen = TypeVar("Chosen")


def model(name: str, **options: Any) -> ModelOptions:
    """Options of a model (a file of models/kinds).

    Parameters
    ----------
    name, options
        Of its file, and as in conf/model; the other options keep their defaults.

    Returns
    -------
    ModelOptions
        What `repro.fit` takes.

    Raises
    ------
    UserError
        For a name or an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> repro.model("structured", hidden=[16]).hidden
    (16,)
    """
    chosen = _checked("models.kinds", name, options, ModelOptions)
    if problem := next(chosen.problems(), None):
        raise UserError(problem)
    return chosen


def optimiser(name: str, **options: Any) -> OptimiserOptions:
    """Options of an optimiser (a file of learning/optimisers).

    Parameters
    ----------
    name, options
        Of its file, and as in conf/optimiser; the other options keep their defaults.

    Returns
    -------
    OptimiserOptions
        What `repro.fit` takes.

    Raises
    ------
    UserError
        For a name or an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> repro.optimiser("adam", epochs=20).epochs
    20
    """
    return _checked("learning.optimisers", name, options, OptimiserOptions)


def objective(name: str, **options: Any) -> ObjectiveOptions:
    """Options of an objective (a file of learning/objectives).

    Parameters
    ----------
    name, options
        Of its file, and as in conf/objective; the other options keep their defaults.

    Returns
    -------
    ObjectiveOptions
        What `repro.fit` takes.

    Raises
    ------
    UserError
        For a name or an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> repro.objective("inverse", error_scale=20.0).error_scale
    20.0
    """
    return _checked(OBJECTIVES, name, options, ObjectiveOptions)


def sequence(name: str, **options: Any) -> SequenceOptions:
    """Options of a sequence of data (a file of learning/sequences).

    Parameters
    ----------
    name, options
        Of its file, and as in conf/sequence; the other options keep their defaults.

    Returns
    -------
    SequenceOptions
        What `repro.fit` takes.

    Raises
    ------
    UserError
        For a name or an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> repro.sequence("joint", initial_angles=10).initial_angles
    10
    """
    return _checked(SEQUENCES, name, options, SequenceOptions)


def metric(name: str, **options: Any) -> MetricOptions:
    """Options of a further metric (a file of evaluation/metrics).

    Parameters
    ----------
    name, options
        Of its file, and as in conf/metric; the other options keep their defaults.

    Returns
    -------
    MetricOptions
        What `FittedModel.score` takes.

    Raises
    ------
    UserError
        For a name or an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> repro.metric("quantiles", shares=[0.5]).shares
    (0.5,)
    """
    return _checked(METRICS, name, options, MetricOptions)


def controller(name: str, **options: Any) -> ControllerOptions:
    """Options of a controller (a file of control/controllers).

    Parameters
    ----------
    name, options
        Of its file, and as in conf/control; the other options keep their defaults.

    Returns
    -------
    ControllerOptions
        What `FittedModel.control` takes.

    Raises
    ------
    UserError
        For a name or an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> repro.controller("mpc", intervals=10).intervals
    10
    """
    return _checked(CONTROLLERS, name, options, ControllerOptions)


def task(start: str = "hanging", **options: Any) -> Task:
    """Where closed loops start and go.

    Parameters
    ----------
    start
        The state of rest that they start at, a name of the system.
    options
        As in conf/task: initial_states, x_des (m), seconds (s), radius of the obstacle (m), noise (of the model), ...

    Returns
    -------
    Task
        What `FittedModel.control` takes.

    Raises
    ------
    UserError
        For an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> repro.task(initial_states=10, x_des=[0.5], noise=1.0).initial_states
    10
    """
    chosen: Task = validated(Task, "task", {"name": "", "start": start, **options})
    return chosen


def system(name: str, *, damping: Sequence[float] = (), reading: str = "physical", **constants: float) -> System:
    """A mechanical system.

    Parameters
    ----------
    name
        Of its file in mechanics/systems, such as "dip".
    damping
        Viscous friction of each coordinate, N s/m or N m s/rad; none by default.
    reading
        "physical" (0 is upright) or "printed", for the systems of the paper.
    constants
        Masses (kg), lengths (m) and others that the system declares; the others keep their values.

    Returns
    -------
    System
        With `coordinates`, `inputs`, `kinetic`, `potential`, `rest_states`, ...

    Raises
    ------
    UserError
        For a system, or a constant of it, that does not exist.

    Examples
    --------
    >>> import repro
    >>> repro.system("sip", m1=0.3).m1
    0.3
    """
    options = {"name": name, "reading": reading, "damping": damping, "constants": constants}
    return load_system(validated(SystemOptions, name, options))


def _checked(folder: str, name: str, options: dict[str, Any], kind: type[Chosen]) -> Chosen:
    chosen = validated(plugin(folder, name).Options, name, options)
    assert isinstance(chosen, kind)
    return chosen
