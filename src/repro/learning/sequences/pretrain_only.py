"""Force-free data with known energy, alone."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from repro.learning.phases import PhaseMaker
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training import Phase


@dataclass(frozen=True)
class Options(SequenceOptions):
    """Options of sequence=pretrain_only."""

    uses_free_motion: ClassVar[bool] = True
    begins_with_free_motion: ClassVar[bool] = True
    ends_on_data: ClassVar[bool] = False

    @property
    def beginning(self) -> SequenceOptions:
        """D_H alone."""
        return Options(**vars(self) | {"pretraining_epochs": None})

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """D_H alone."""
        yield make.phase("D_H", make.free(), epochs=self.pretraining_epochs)
