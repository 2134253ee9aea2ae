"""Learning curves of the single pendulum: objectives and optimisers."""

from functools import partial
from typing import TYPE_CHECKING

from repro.report import style
from repro.report.figures.curves import LOSS, Quantity, curve_panels, with_curves
from repro.report.figures.figure import Figure
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

INERTIA = Quantity("min_eig_M", "min eig M [kg, kg m²]", small=1e-3)
NET = {"model": "lagrangian", "basis": "t2", "hidden": "10", "objective": "inverse"}
ROLES = {"inverse": style.INVERSE, "forward": style.FORWARD}


def draw_objectives(results: Results, quantity: Quantity) -> "Canvas | None":
    """Draw one panel per net and optimiser, inverse against forward."""
    panels: dict[str, list[tuple[str, RunSetting]]] = {}
    for setting in with_curves(results, settings(results, "sip_forward_inverse"), quantity):
        title = setting.title("basis", "hidden", "optimiser")
        panels.setdefault(title, []).append((str(setting.card["objective"]), setting))
    return curve_panels(results, panels, ROLES, quantity)


def draw_optimisers(results: Results) -> "Canvas | None":
    """Draw one panel with a line per optimiser, on the same net."""
    lines = [(_optimiser(s), s) for s in with_curves(results, settings(results, "sip_optimisers", NET))]
    names = list(dict.fromkeys(name for name, _ in lines))
    roles = {name: style.SERIES[index % len(style.SERIES)] for index, name in enumerate(names)}
    return curve_panels(results, {"T2/V1, 1x10, inverse": lines} if lines else {}, roles)


def _optimiser(setting: RunSetting) -> str:
    name = setting.title("optimiser")
    return f"{name}, curriculum" if setting.card["curriculum"] not in ("", "none", "false") else name


FIGURES = (
    Figure(
        "learning_curves_objectives",
        "Learning curves: inverse against forward",
        "Identical nets and budgets. Thin lines are members, the thick one their median; it ends where most have "
        "diverged.",
        "One panel per network and optimiser: loss over steps, both logarithmic; solid lines are inverse fits, dashed "
        "ones forward.",
        partial(draw_objectives, quantity=LOSS),
    ),
    Figure(
        "learning_curves_inertia",
        "The mass matrix while learning: inverse against forward",
        "Least eigenvalue of the learned M over samples of the test set; where it crosses zero the model has no "
        "forward dynamics. Identical nets and budgets. Thin lines are members, the thick one their median.",
        "One panel per network and optimiser: least eigenvalue of the mass matrix over steps, with zero marked; solid "
        "lines are inverse fits, dashed ones forward.",
        partial(draw_objectives, quantity=INERTIA),
    ),
    Figure(
        "learning_curves_optimisers",
        "Learning curves: optimisers",
        "The paper's net (T2/V1, 1x10, inverse objective) under different optimisers. Thin lines are members.",
        "Loss over steps, both logarithmic, one line style per optimiser.",
        draw_optimisers,
    ),
)
