"""Units of recorded columns, as factors to SI units."""

import math
from collections.abc import Sequence

from repro.errors import UserError

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
OTHERS = {
    **{"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    **{"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "turn": 2 * math.pi, "rpm": 2 * math.pi / 60},
    **{"N": 1.0, "kN": 1e3, "mN": 1e-3, "N m": 1.0, "Nm": 1.0, "mN m": 1e-3, "mNm": 1e-3},
}
RATES = ("/s^2", "/s2", "/s²", "/s")  # may follow the unit of a coordinate


def factor(unit: str | float, *, time: bool = False) -> float:
    """What a number in this unit, or with this factor, is multiplied by; UserError names the units there are."""
    if not isinstance(unit, str):
        if not math.isfinite(unit) or unit == 0:
            raise UserError(f"data.units: {unit} is no factor: give a unit, or a number other than 0")
        return float(unit)
    known = SECONDS if time else OTHERS
    base = next((unit.removesuffix(end) for end in RATES if not time and unit.endswith(end)), unit)
    if base not in known:
        raise UserError(f"data.units: {unit!r} is not known; allowed are {', '.join(known)}, or a factor to SI units")
    return known[base]


def factors(units: Sequence[str | float], columns: int, role: str) -> list[float]:
    """One factor per column, 1 where no units are given; UserError where there are not as many units as columns."""
    if not units:
        return [1.0] * columns
    if len(units) != columns:
        raise UserError(f"data.units.{role} = {list(units)}: needs one unit for each of the {columns} columns, or none")
    return [factor(unit, time=role == "time") for unit in units]
