"""What every choice of conf/control declares: its options, and the systems that it can drive."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

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

    time_step    s, between two steps
    force_limit  of all inputs, in their units; None: that of each, as the system has it
    drives       the systems that it can drive, in words
    """

    drives: ClassVar[str] = "every system"

    time_step: Positive = 0.04
    force_limit: Positive | None = None

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
