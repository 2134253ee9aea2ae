"""Options of the true system."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Literal

from repro.plugins.options import NotNegative, Options

SYSTEMS = "mechanics.systems"  # the folder of these choices


class Reading(StrEnum):
    """Of the paper's conventions: angles from upright and energies that balance, or eq. (13) and the DIP as printed."""

    PHYSICAL = "physical"
    PRINTED = "printed"


@dataclass(frozen=True)
class SystemOptions(Options):
    """The true system: its name, the reading of the paper's conventions, friction, and constants by name."""

    name: str
    reading: Reading = Reading.PHYSICAL
    damping: tuple[NotNegative, ...] = ()
    damping_frame: Literal["relative", "absolute"] = "relative"
    damping_growth: NotNegative = 0.0
    coulomb: tuple[NotNegative, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """All options as plain data."""
        return {**super().plain(), "constants": dict(self.constants)}
