"""What every choice of conf/control declares: its options, and the systems that it can drive."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from repro.mechanics.inputs import input_matrix
from repro.mechanics.system import System
from repro.plugins.options import PluginOptions, Positive

CONTROLLERS = "control.controllers"  # the folder of these choices


@dataclass(frozen=True, kw_only=True)
class ControlOptions(PluginOptions):
    """A choice of conf/control; name: of its file there."""

    name: str


@dataclass(frozen=True, kw_only=True)
class ControllerOptions(ControlOptions):
    """Options of a controller.

    A file of control/controllers extends it and has `build(options, model, disc, samples)`: a context manager that
    yields a `MakeController`, from a `PredictiveModel`, the `Disc` to avoid or None, and training data as `Samples`.

    time_step    s, between two forces
    force_limit  N
    drives       the systems that it can drive, in words
    """

    drives: ClassVar[str] = "a cart with links"

    time_step: Positive
    force_limit: Positive

    def fits(self, system: System) -> bool:
        """Whether it can drive a system: a cart with links, and one input, the force on the cart."""
        first, *links = system.coordinates
        on_cart = np.eye(system.n_q)[:, :1]
        is_cart = first.unit == "m" and first.cyclic and bool(links) and all(link.is_angle for link in links)
        return is_cart and np.array_equal(input_matrix(system, np.zeros(system.n_q)), on_cart)
