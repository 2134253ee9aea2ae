"""The front figure: each printed number against what our members gave, one strip per claim."""

from typing import TYPE_CHECKING, Any

import numpy as np

from repro.claims.claims import Claim, ClaimKind, load_claims
from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import Verdict, judge
from repro.report import style
from repro.report.figures.figure import Figure, legend, new_canvas
from repro.report.style import TEXT_WIDTH, Role
from repro.results.metric_names import metric_named
from repro.results.results import Results
from repro.results.selectors import NotRunError, one_setting
from repro.tracking.paths import project_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

CONSISTENT, OUTSIDE, NOT_COMPARED = (
    Role("#10305c", "-", "o"),
    Role("#e2680a", "-", "s"),
    Role("#8c8c8c", "-", "D", filled=False),
)
ROLES = {"consistent": CONSISTENT, "outside": OUTSIDE, "not compared (declared, or too few)": NOT_COMPARED}
ROLE_OF = {VerdictKind.CONSISTENT: CONSISTENT, VerdictKind.OUTSIDE: OUTSIDE}
DECADES = 6.0  # shown to either side; what lies beyond is drawn at the edge


def draw(results: Results) -> "Canvas | None":
    """Draw a row per printed number: members' values and the 95 % prediction interval, over the printed value."""
    rows = [row for claim in load_claims(project_folder() / "paper" / "claims.yaml") if (row := _row(claim, results))]
    if not rows:
        return None
    canvas = new_canvas(TEXT_WIDTH, 1.1 + 0.24 * len(rows))
    panel = canvas.subplots()
    for height, (verdict, values) in enumerate(reversed(rows)):
        _strip(panel, height, verdict, values)
    panel.axvline(1.0, zorder=1.5, **style.PAPER.line_style)
    panel.set_xscale("log")
    panel.set_yticks(range(len(rows)), [_title(verdict) for verdict, _ in reversed(rows)])
    panel.set_ylim(-0.7, len(rows) - 0.3)
    panel.set_xlabel("our value / printed value")
    panel.grid(visible=False, axis="y")
    used = [ROLE_OF.get(verdict.verdict, NOT_COMPARED) for verdict, _ in rows]
    roles = {name: role for name, role in ROLES.items() if role in used}
    legend(canvas, panel, roles, lines={"printed in the paper": style.PAPER}, columns=4)
    return canvas


def _row(claim: Claim, results: Results) -> tuple[Verdict, np.ndarray] | None:
    """Return a claim's verdict and its members' values; None where no number is printed or nothing was run."""
    if claim.kind is ClaimKind.STATEMENT or not claim.printed or not claim.metric:
        return None
    try:
        values = one_setting(results, claim.experiment, claim.selector).values(claim.metric)
    except NotRunError:
        return None
    return (judge(claim, results), values) if np.any(values > 0) else None


def _strip(panel: Any, height: int, verdict: Verdict, values: np.ndarray) -> None:
    printed = float(verdict.claim.printed or np.nan)
    role = ROLE_OF.get(verdict.verdict, NOT_COMPARED)
    least, most = 10.0**-DECADES, 10.0**DECADES
    if np.all(np.isfinite(verdict.prediction)):
        ends = np.clip(np.array(verdict.prediction) / printed, least, most)
        panel.plot(ends, [height] * 2, color="#c9c9c9", linewidth=5, solid_capstyle="butt", zorder=1)
    shown = np.clip(values[np.isfinite(values) & (values > 0)] / printed, least, most)
    panel.plot(shown, np.full(shown.size, height), alpha=0.7, zorder=2, **role.marker_style)


def _title(verdict: Verdict) -> str:
    claim = verdict.claim
    return f"{claim.name}: {metric_named(claim.metric).label} = {claim.printed:.3g}"


FIGURES = (
    Figure(
        "printed_values",
        "Every printed number against ours",
        "One row per number that the paper prints. Each marker is one member, the grey bar the interval in which one "
        "more member falls with 95 %. A printed number is one draw of an unknown seed: it is consistent when 1 lies on "
        "the bar. A wide bar excludes little. C1 to C5: the single pendulum; C8 and C9: the double one.",
        "Strip plot on a logarithmic axis: our values over the printed value, one row per claim, prediction intervals "
        "as grey bars and the printed value as a vertical line at 1.",
        draw,
    ),
)
