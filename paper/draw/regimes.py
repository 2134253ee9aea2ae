"""What the way of collecting data does to the errors."""

from typing import TYPE_CHECKING

from repro.report import style
from repro.report.figures.dots import dot_plot
from repro.report.figures.figure import Figure
from repro.report.style import Role
from repro.report.tables.models import model_title
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import DEGENERATE, ORACLE, TRIVIAL, anchor_name, settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "sip_regimes"
METRICS = {"mae_tau": "N, N m", "mae_qdd": "m/s², rad/s²", "onestep_euler_qd[0]": "m/s"}
PRINTED = {"mae_tau": 0.26, "onestep_euler_qd[0]": 0.05}


def draw(results: Results) -> "Canvas | None":
    """Draw one row per way of collecting data; learned models and the closed form beside each other."""
    rows: dict[str, list[tuple[RunSetting, Role]]] = {}
    roles: dict[str, Role] = {}
    learned = iter(style.SERIES)
    for setting in settings(results, EXPERIMENT):
        if anchor_name(setting) in (TRIVIAL, DEGENERATE):
            continue
        if anchor_name(setting) == ORACLE:
            role = roles.setdefault("least squares on T1/V1", style.ANCHOR_DOT)
        else:
            kind = model_title(setting, "optimiser")
            role = roles[kind] if kind in roles else roles.setdefault(kind, next(learned))
        rows.setdefault(_title(setting), []).append((setting, role))
    if not rows:
        return None
    return dot_plot(list(rows.items()), METRICS, roles=roles, printed=PRINTED)


def _title(setting: RunSetting) -> str:
    card = setting.card
    title = "one long run" if card["regime"] == "long" else f"episodes of {card['episode_steps']} steps"
    parts = [title]
    if card["labels"] != "exact":
        parts.append(f"{card['labels']} labels")
    if card["tau_noise"]:
        parts.append(f"noise {card['tau_noise']:g}")
    return ", ".join(parts)


FIGURES = (
    Figure(
        "regimes",
        "Data regimes",
        "Each dot is a member, each bar the median. The Euler error of the closed form is that of the integrator "
        "alone: where it equals the printed value, the printed value says nothing about a learned model.",
        "Dot plot: one row per data regime, one panel per metric, logarithmic; the printed values as vertical lines.",
        draw,
    ),
)
