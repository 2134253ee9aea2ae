"""The typed options of a choice, by its name: what the command line reads from conf/ and Python code from here."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from repro.control.controller import CONTROLLERS, ControllerOptions
from repro.control.task import Task
from repro.errors import UserError
from repro.evaluation.metric_options import METRICS, MetricOptions
from repro.learning.objective_options import OBJECTIVES, ObjectiveOptions
from repro.learning.optimiser_options import OPTIMISERS, OptimiserOptions
from repro.learning.sequence_options import SEQUENCES, SequenceOptions
from repro.mechanics.system import System, load
from repro.models.model_options import MODELS, ModelOptions
from repro.plugins.checked import validated
from repro.plugins.plugin import plugin

Chosen = TypeVar("Chosen")

DOCSTRING = """Options of {what} (a file of {folder}).

    Parameters
    ----------
    name, options
        Of its file, and as in {settings}; the other options keep their defaults.

    Returns
    -------
    {kind}
        What `{taken_by}` takes.

    Raises
    ------
    UserError
        For a name or an option that does not exist, and for a value that is not allowed.

    Examples
    --------
    >>> import repro
    >>> {example}
    {shown}
"""


def _choice(
    what: str, kind: type[Chosen], folder: str, settings: str, taken_by: str, example: str, shown: str
) -> Callable[..., Chosen]:
    """The function that makes the options of one kind of choice; what `example` gives is `shown` in its docstring."""

    def choice(name: str, **options: Any) -> Chosen:
        chosen = validated(plugin(folder, name).Options, name, options)
        assert isinstance(chosen, kind)
        if isinstance(chosen, ModelOptions) and (problem := next(chosen.problems(), None)):
            raise UserError(problem)
        return chosen

    choice.__name__ = choice.__qualname__ = what.rpartition(" ")[2]
    choice.__annotations__["return"] = kind
    choice.__doc__ = DOCSTRING.format(
        what=what, folder=folder.replace(".", "/"), settings=settings, kind=kind.__name__, taken_by=taken_by,
        example=example, shown=shown,
    )  # fmt: skip
    return choice


model = _choice(
    "a model", ModelOptions, MODELS, "conf/model", "repro.fit",
    'repro.model("structured", hidden=[16]).hidden', "(16,)",
)  # fmt: skip
optimiser = _choice(
    "an optimiser", OptimiserOptions, OPTIMISERS, "conf/optimiser", "repro.fit",
    'repro.optimiser("adam", epochs=20).epochs', "20",
)  # fmt: skip
objective = _choice(
    "an objective", ObjectiveOptions, OBJECTIVES, "conf/objective", "repro.fit",
    'repro.objective("inverse", error_scale=20.0).error_scale', "20.0",
)  # fmt: skip
sequence = _choice(
    "a sequence", SequenceOptions, SEQUENCES, "conf/sequence", "repro.fit",
    'repro.sequence("joint", initial_angles=10).initial_angles', "10",
)  # fmt: skip
metric = _choice(
    "a further metric", MetricOptions, METRICS, "conf/metric", "FittedModel.score",
    'repro.metric("quantiles", shares=[0.5]).shares', "(0.5,)",
)  # fmt: skip
controller = _choice(
    "a controller", ControllerOptions, CONTROLLERS, "conf/control", "FittedModel.control",
    'repro.controller("mpc", intervals=10).intervals', "10",
)  # fmt: skip


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
    return load(name, reading, damping, **constants)
