"""Options of the true system."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from repro.plugins.options import Options


@dataclass(frozen=True)
class SystemOptions(Options):
    """The true system: its name, the reading of the paper's conventions, friction, and constants by name."""

    name: str
    reading: Literal["physical", "printed"] = "physical"
    damping: tuple[float, ...] = ()
    damping_frame: Literal["relative", "absolute"] = "relative"
    damping_growth: float = 0.0
    coulomb: tuple[float, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """All options as plain data."""
        return {**super().plain(), "constants": dict(self.constants)}
