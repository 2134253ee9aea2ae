"""D alone."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Self

from repro.learning.phases import PhaseMaker
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training import Phase


@dataclass(frozen=True)
class Options(SequenceOptions):
    """The options of sequence=main have no effect."""

    needs_energies: ClassVar[bool] = False

    @property
    def effective(self) -> Self:
        """None."""
        return type(self)()

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """The curriculum."""
        yield from make.curriculum("D")
