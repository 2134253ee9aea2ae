"""D and the known energy of one state (III-A.1)."""

from collections.abc import Iterator
from dataclasses import dataclass

from repro.learning.phases import PhaseMaker
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training import Phase


@dataclass(frozen=True)
class Options(SequenceOptions):
    """Options of sequence=anchored."""

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """Every stage with that state beside it."""
        yield from make.curriculum("D", make.anchor())
