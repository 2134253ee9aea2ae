"""D_H and D together."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from repro.learning.phases import PhaseMaker
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training import Phase


@dataclass(frozen=True)
class Options(SequenceOptions):
    """Options of sequence=joint."""

    uses_free_motion: ClassVar[bool] = True

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """Every stage with D_H beside it."""
        yield from make.curriculum("D and D_H", make.free())
