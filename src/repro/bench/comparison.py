"""One paired comparison: its contenders and their size, how they are measured, and the row of the results."""

from collections.abc import Callable
from dataclasses import dataclass

from repro.bench.pairing import Pairs

THREADS = 1


@dataclass(frozen=True)
class PairedComparison:
    """Seconds of two contenders in pairs.

    members   networks trained side by side in one timing, whose time is that of all of them together
    protocol  how it is measured; {pairs} stands for their number, {found} for the remark of the measurement
    """

    name: str
    ours: str
    other: str
    size: str
    members: int
    protocol: str
    measure: Callable[[], Pairs]

    @property
    def label(self) -> str:
        """A label for the progress."""
        return f"{self.name} {self.size}: {self.ours} / {self.other}"

    def row(self, pairs: Pairs) -> dict[str, object]:
        """The row of the results, its columns in the order of the stored table."""
        return {
            "name": self.name,
            "ours": self.ours,
            "other": self.other,
            "size": self.size,
            "members": self.members,
            **pairs.summary(),
            "threads": THREADS,
            "protocol": self.protocol.format(pairs=len(pairs), found=pairs.found),
        }
