"""The paper's: D_H, then fine-tuned on D."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from repro.learning.phases import PhaseMaker
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training import Phase


@dataclass(frozen=True)
class Options(SequenceOptions):
    """Options of sequence=pretrain."""

    uses_free_motion: ClassVar[bool] = True
    begins_with_free_motion: ClassVar[bool] = True

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """D_H alone, then the curriculum."""
        yield make.phase("D_H", make.free(), epochs=self.pretraining_epochs)
        yield from make.curriculum("D")
