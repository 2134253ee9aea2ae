"""What every choice of conf/control declares, what a closed loop needs of a controller, and the record of a step."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import ClassVar, Protocol

import numpy as np

from repro.control.goal import Goal
from repro.mechanics.inputs import input_limits
from repro.mechanics.system import System
from repro.plugins.options import PluginOptions, Positive

CONTROLLERS = "control.controllers"  # the folder of these choices


@dataclass(frozen=True, kw_only=True)
class ControlOptions(PluginOptions):
    """A choice of conf/control; name: of its file there."""

    name: str = ""


@dataclass(frozen=True, kw_only=True)
class ControllerOptions(ControlOptions):
    """Options of a controller.

    A file of control/controllers extends it and has `build(options, model, disc, samples)`: a context manager that
    yields a `MakeController`, from a `PredictiveModel`, the `Disc` to avoid or None, and training data as `Samples`.
    """

    drives: ClassVar[str] = "every system"  # the systems that it can drive, in words

    time_step: Positive = 0.04  # s, between two steps
    force_limit: Positive | None = None  # of all inputs, in their units; None: that of each, as the system has it

    def limits(self, system: System) -> tuple[float, ...]:
        """The limit of every input."""
        return tuple(input_limits(system)) if self.force_limit is None else (self.force_limit,) * len(system.inputs)

    @property
    def adapts(self) -> bool:
        """Whether it re-identifies the weights of the model."""
        return False

    def fits(self, system: System) -> bool:
        """Whether it can drive a system."""
        return True

    def problems(self, system: System) -> Iterator[str]:
        """Options that do not fit a system, one line each."""
        yield from ()


@dataclass(frozen=True)
class ControlStep:
    """The inputs of one step (n_u,), and how they were computed."""

    u: np.ndarray
    fallback: int = 0  # 0 the solver's first answer; 1 a second try; 2 the last good plan; 3 inputs 0
    status: str = ""  # the solver's last word
    iterations: int = 0  # of all solutions
    seconds: float = 0.0  # CPU time of all solutions
    killed: int = 0  # number of solutions that were stopped because they took too much CPU time
    plan: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))  # predicted states (nodes, 2 n_q); empty without


class Controller(Protocol):
    """Computes the inputs of the next step from measured states."""

    def decide(self, state: np.ndarray) -> ControlStep:
        """The inputs at a measured state (2 n_q,)."""

    def observe(self, samples: np.ndarray, inputs: np.ndarray) -> None:
        """Learn from the step: samples (n + 1, 2 n_q) measured under inputs (n, n_u) held between them.

        Nothing is learned unless said.
        """
        return


Samples = tuple[np.ndarray, np.ndarray, np.ndarray]
"""q, qd, qdd (sample, n_q) of training data."""
MakeController = Callable[[np.ndarray, Goal], Controller]
"""Makes a controller from the weights of a model (n_parameters,) and the goal."""
