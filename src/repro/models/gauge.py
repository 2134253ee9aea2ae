"""Which of the Lagrangians with the same motion a learned one is read as; see `repro.evaluation.canonical`."""

from enum import StrEnum


class Gauge(StrEnum):
    """As learned; with one known energy; with T = 0 at rest; or both."""

    RAW = "raw"
    ANCHOR = "anchor"
    CANONICAL = "canonical"
    CANONICAL_ANCHOR = "canonical_anchor"

    @property
    def is_canonical(self) -> bool:
        """Whether T vanishes at rest."""
        return self in (Gauge.CANONICAL, Gauge.CANONICAL_ANCHOR)

    @property
    def is_anchored(self) -> bool:
        """Whether one energy is known."""
        return self in (Gauge.ANCHOR, Gauge.CANONICAL_ANCHOR)
