"""The paper's: D_H, then fine-tuned on D."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from repro.learning.phases import PhaseMaker
from repro.learning.sequences import pretrain_only
from repro.learning.training import Phase


@dataclass(frozen=True)
class Options(pretrain_only.Options):
    """Options of sequence=pretrain."""

    ends_on_data: ClassVar[bool] = True

    def phases(self, make: PhaseMaker) -> Iterator[Phase]:
        """D_H alone, then the curriculum."""
        yield from super().phases(make)
        yield from make.curriculum("D")
