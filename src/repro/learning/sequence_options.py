"""What every sequence of data declares: its options, its phases, and which data it needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

from annotated_types import Ge

from repro.learning.objective_options import EnergyForm
from repro.plugins.options import Count, PluginOptions, Positive

if TYPE_CHECKING:
    from repro.learning.phases import PhaseMaker
    from repro.learning.training import Phase

SEQUENCES = "learning.sequences"  # the folder of these choices


@dataclass(frozen=True)
class SequenceOptions(PluginOptions):
    """Options of a sequence (see conf/sequence/_base.yaml); a file of learning/sequences has them and `phases`."""

    needs_energies: ClassVar[bool] = True  # it compares energies, which simulated data and a model with energies have
    uses_free_motion: ClassVar[bool] = False  # D_H is learned
    begins_with_free_motion: ClassVar[bool] = False  # there is a phase on D_H alone
    ends_on_data: ClassVar[bool] = True  # the last phase is on D

    energy_weight: Positive = 1.0
    energy_form: EnergyForm = EnergyForm.LEGENDRE
    initial_angles: Annotated[int, Ge(2)] = 100
    grid: Literal["product", "diagonal"] = "product"
    steps: Count = 10
    pretraining_epochs: Count | None = None

    @property
    def beginning(self) -> SequenceOptions | None:
        """The sequence of its first phase alone, without epochs of its own, where other sequences share that phase."""
        return None

    @property
    def effective(self) -> Self:
        """The options that have an effect, all others at their defaults."""
        return self

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """The phases in turn."""
        raise NotImplementedError
