"""D_H and D together."""

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
    """Options of sequence=joint."""

    uses_free_motion: ClassVar[bool] = True

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """Every stage with D_H beside it."""
        yield from make.curriculum("D and D_H", make.free())
