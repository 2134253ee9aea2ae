"""No closed loop."""

from dataclasses import dataclass

from repro.control.controller import ControlOptions


@dataclass(frozen=True, kw_only=True)
class Options(ControlOptions):
    """Options of control=none."""
