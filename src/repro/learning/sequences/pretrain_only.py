"""Force-free data with known energy, alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.learning.sequence_options import SequenceOptions

if TYPE_CHECKING:
    from repro.learning.phases import PhaseMaker
    from repro.learning.training import Phase


@dataclass(frozen=True)
class Options(SequenceOptions):
    """Options of sequence=pretrain_only."""

    uses_free_motion: ClassVar[bool] = True
    begins_with_free_motion: ClassVar[bool] = True
    ends_on_data: ClassVar[bool] = False

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """D_H alone."""
        yield make.phase("D_H", make.free(), epochs=self.pretraining_epochs)
