"""Success of the printed controllers against the time step, which the paper does not give: one panel per setting."""

import json
from typing import TYPE_CHECKING, Any

from repro.report import style
from repro.report.figures.figure import Figure, legend, small_multiples
from repro.report.style import Role
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.statistics import Estimate, share
from repro.results.table_schema import as_text, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

EXPERIMENT, STEP = "mpc_time_step", "control.time_step"
APART = 0.0012  # s between the markers of two models at one time step
TITLES = {
    "sip_printed": "single pendulum, N_p = 10",
    "sip_printed_setup": "single pendulum, N_p = 20",
    "dip_printed": "double pendulum, N_p = 10",
}
DRAWN = {"truth": ["run", "start", "x_des"]}  # the unit of replication; of a learned model the member


def draw(results: Results) -> "Canvas | None":
    """Draw the share of successes with its Wilson interval, one line per model."""
    loops = results.control[results.control["experiment"] == EXPERIMENT]
    if loops.empty:
        return None
    configs = {
        run: json.loads(config or "{}") for run, config in results.runs[["run", "config"]].itertuples(index=False)
    }
    loops = loops.assign(
        step=[configs[run].get(STEP) for run in loops["run"]],
        name=[_model(row, configs[row["run"]]) for row in loops.to_dict("records")],
    )
    names = list(dict.fromkeys(loops["name"]))
    roles = dict(zip(names, style.SERIES, strict=False))
    order = [*TITLES, *sorted({*loops["setting"]} - {*TITLES})]
    panels_of = sorted(loops.groupby("setting"), key=lambda each: order.index(str(each[0])))
    canvas, panels = small_multiples(len(panels_of), min(3, len(panels_of)), 2.3, 0.9, share_y=True)
    for panel, (setting, group) in zip(panels, panels_of, strict=True):
        for name, of_model in group.groupby("name", sort=False):
            points = [(step, _share(at_step)) for step, at_step in of_model.groupby("step")]
            _line(panel, points, roles[name], APART * names.index(name))
        panel.set_title(TITLES.get(str(setting), str(setting)))
        panel.set_xlabel("time step of the controller [s]")
        panel.set_ylim(-0.05, 1.05)
    panels[0].set_ylabel("share of loops that succeed")
    legend(canvas, panels[0], {}, lines=roles)
    return canvas


def _line(panel: Any, points: list[tuple[float, Estimate]], role: Role, offset: float) -> None:
    steps = [step + offset for step, _ in points]
    medians = [found.median for _, found in points]
    panel.plot(steps, medians, **role.marked_line_style)
    panel.vlines(steps, [found.low for _, found in points], [found.high for _, found in points], color=role.colour)


def _share(loops: "pd.DataFrame") -> Estimate:
    units = DRAWN.get(str(loops["model"].iloc[0]), ["member"])
    return share([float(unit["success"].mean()) for _, unit in loops.groupby(units, dropna=False)])


def _model(row: dict[str, object], config: dict[str, object]) -> str:
    """Name a model by its basis, unless it has none, and by its optimiser."""
    model, basis = as_text(plain(row["model"])), as_text(plain(row["basis"]))
    if model == "truth":
        return "true model"
    name = written("basis", basis) if model == "lagrangian" else written("model", model)
    return f"{name}, {written('optimiser', as_text(config.get('optimiser.name')))}"


FIGURES = (
    Figure(
        "time_step",
        "Success against the controller's time step",
        "Printed settings of the predictive controller at five time steps. The paper gives 0.04 s for the data only. "
        "Bars: Wilson intervals of 95 %, models side by side. True model: one loop to each of 20 targets x from 0.2 to "
        "1.15 m; learned models: one loop of each of 20 members to 0.8 m.",
        "One panel per printed setting: share of successful loops against the time step, one line per model, with "
        "vertical intervals.",
        draw,
    ),
)
