"""Which of the Lagrangians with the same motion a learned one is read as; see `repro.evaluation.canonical`."""

from enum import StrEnum
from typing import assert_never


class Gauge(StrEnum):
    """As learned; with one known energy; with T = 0 at rest; or both."""

    RAW = "raw"
    ANCHOR = "anchor"
    CANONICAL = "canonical"
    CANONICAL_ANCHOR = "canonical_anchor"

    @property
    def is_canonical(self) -> bool:
        """Whether T vanishes at rest."""
        match self:
            case Gauge.CANONICAL | Gauge.CANONICAL_ANCHOR:
                return True
            case Gauge.RAW | Gauge.ANCHOR:
                return False
            case _:
                assert_never(self)

    @property
    def is_anchored(self) -> bool:
        """Whether one energy is known."""
        match self:
            case Gauge.ANCHOR | Gauge.CANONICAL_ANCHOR:
                return True
            case Gauge.RAW | Gauge.CANONICAL:
                return False
            case _:
                assert_never(self)
