"""How far each assumption moves the numbers that claims are judged by, and whether it moves a verdict."""

import math
from collections.abc import Sequence

from repro.claims.assumption_effects import AssumptionEffect
from repro.report.figures.figure import Canvas, Figure, legend, new_canvas
from repro.report.style import TEXT_WIDTH, Role

MOVED = Role("#e2680a", "-", "o")
STAYED = Role("#10305c", "-", "o", filled=False)
DECADES = 6.0  # shown to either side


def sensitivity_figure(effects: Sequence[AssumptionEffect]) -> Figure:
    """Return the figure: one row per assumption, the factors by which its alternatives change the values of claims."""
    return Figure(
        "sensitivity",
        "Which assumptions matter",
        "One assumption changed at a time, at scale quick with three members: each marker is one alternative and one "
        "claim. Values that are negative, or a share of zero, have no place here and stand in the table; changes of "
        "more than six decades are drawn at six.",
        "One row per assumption: how much another choice changes a claim's number, on a logarithmic axis.",
        lambda _results: _drawn(effects),
    )


def _drawn(effects: Sequence[AssumptionEffect]) -> Canvas | None:
    # By assumption: decades between the two values, and whether the verdict moves; positive values alone have them.
    factors: dict[str, list[tuple[float, bool]]] = {}
    for each in effects:
        ours, other = each.ours.estimate.median, each.other.estimate.median
        if each.moved is not None and 0 < ours < math.inf and 0 < other < math.inf:
            decades = max(-DECADES, min(DECADES, math.log10(other / ours)))
            factors.setdefault(each.assumption, []).append((decades, each.moved))
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
    panel.set_xticks(ticks, [f"$10^{{{tick}}}$" if tick else "1" for tick in ticks])
    panel.set_xlabel("value by the alternative / value by our choice")
    panel.grid(visible=False, axis="y")
    legend(canvas, panel, {"the verdict moves": MOVED, "it stays": STAYED})
    return canvas
