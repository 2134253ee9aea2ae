"""How far each assumption moves the numbers that claims are judged by, and whether it moves a verdict."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from repro.claims.assumption_effects import AssumptionEffect, assumption_effects
from repro.claims.claims import load_claims
from repro.report.figures.figure import Figure, legend, new_canvas
from repro.report.style import TEXT_WIDTH, Role
from repro.results.results import Results
from repro.tracking.paths import project_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

MOVED = Role("#e2680a", "-", "o")
STAYED = Role("#10305c", "-", "o", filled=False)
DECADES = 6.0  # shown to either side


def draw(results: Results) -> "Canvas | None":
    """Draw one row per assumption: the factor by which each alternative changes the value of each claim."""
    if results.sensitivity is None:
        return None
    factors = _factors(assumption_effects(results.sensitivity, load_claims(project_folder() / "paper" / "claims.yaml")))
    if not factors:
        return None
    names = sorted(factors, key=lambda name: max(abs(decades) for decades, _ in factors[name]))
    canvas = new_canvas(TEXT_WIDTH, 1.0 + 0.19 * len(names))
    panel = canvas.subplots()
    for height, name in enumerate(names):
        ends = [decades for decades, _ in factors[name]]
        panel.plot([min(0.0, *ends), max(0.0, *ends)], [height, height], color="#c9c9c9", linewidth=1.5, zorder=1)
        for decades, moved in sorted(factors[name], key=lambda point: bool(point[1])):
            panel.plot(decades, height, zorder=3 if moved else 2, **(MOVED if moved else STAYED).marker_style)
    panel.axvline(0.0, color="black", linewidth=0.8)
    panel.set_yticks(range(len(names)), names)
    panel.set_ylim(-0.7, len(names) - 0.3)
    reach = math.ceil(max(abs(decades) for points in factors.values() for decades, _ in points))
    ticks = range(-reach, reach + 1)
    panel.set_xticks(ticks, [_power(tick) for tick in ticks])
    panel.set_xlabel("value by the alternative / value by our choice")
    panel.grid(visible=False, axis="y")
    legend(canvas, panel, {"the verdict moves": MOVED, "it stays": STAYED})
    return canvas


def _factors(compared: Sequence[AssumptionEffect]) -> Mapping[str, list[tuple[float, bool]]]:
    """Decades between the two values, and whether the verdict moves, by assumption; positive values alone have them."""
    factors: dict[str, list[tuple[float, bool]]] = {}
    for each in compared:
        ours, other = each.ours.estimate.median, each.other.estimate.median
        if each.moved is None or not (math.isfinite(ours) and math.isfinite(other) and ours > 0 and other > 0):
            continue
        decades = max(-DECADES, min(DECADES, math.log10(other / ours)))
        factors.setdefault(each.assumption, []).append((decades, each.moved))
    return factors


def _power(decades: int) -> str:
    return "1" if decades == 0 else f"$10^{{{decades}}}$"


SENSITIVITY = Figure(
    "sensitivity",
    "Which assumptions matter",
    "One assumption changed at a time, at scale quick with three members: each marker is one alternative and one "
    "claim. Values that are negative, or a share of zero, have no place here and stand in the table; changes of "
    "more than six decades are drawn at six.",
    "One row per assumption: how much another choice changes a claim's number, on a logarithmic axis.",
    draw,
)
