"""Options of the order in which data are learned."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Literal

from annotated_types import Ge

from repro.learning.objective_options import EnergyForm
from repro.plugins.options import Count, Options, Positive


class SequenceKind(StrEnum):
    """Which data in which order; D_H is free motion, whose energy is known."""

    MAIN = "main"
    ANCHORED = "anchored"
    PRETRAIN_ONLY = "pretrain_only"
    PRETRAIN = "pretrain"
    JOINT = "joint"

    @property
    def uses_free_motion(self) -> bool:
        """Whether D_H is learned."""
        return self in (SequenceKind.PRETRAIN_ONLY, SequenceKind.PRETRAIN, SequenceKind.JOINT)

    @property
    def begins_with_free_motion(self) -> bool:
        """Whether there is a phase on D_H alone."""
        return self in (SequenceKind.PRETRAIN_ONLY, SequenceKind.PRETRAIN)


@dataclass(frozen=True)
class SequenceOptions(Options):
    """Options of conf/sequence.

    energy_weight, energy_form: of the energy error. initial_angles, grid, steps: of D_H, as in `FreeMotionOptions`.
    pretraining_epochs: on D_H alone; None: as many as on D.
    """

    kind: SequenceKind = SequenceKind.MAIN
    energy_weight: Positive = 1.0
    energy_form: EnergyForm = EnergyForm.LEGENDRE
    initial_angles: Annotated[int, Ge(2)] = 100
    grid: Literal["product", "diagonal"] = "product"
    steps: Count = 10
    pretraining_epochs: Count | None = None
