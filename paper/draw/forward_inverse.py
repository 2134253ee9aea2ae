"""Forward against inverse on identical nets, every member shown."""

from typing import TYPE_CHECKING

from repro.report import style
from repro.report.figures.dots import dot_plot
from repro.report.figures.figure import Figure
from repro.report.style import Role
from repro.report.tables.models import model_title
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import TRIVIAL, anchor, anchor_name, settings, test_set_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "sip_forward_inverse"
ROLES = {"inverse": style.INVERSE, "forward": style.FORWARD}
METRICS = {"mae_tau": "N, N m", "mae_qdd": "m/s², rad/s²"}


def draw(results: Results) -> "Canvas | None":
    """Draw one row per net and optimiser, both objectives in it."""
    learned = [setting for setting in settings(results, EXPERIMENT) if anchor_name(setting) is None]
    rows: dict[str, list[tuple[RunSetting, Role]]] = {}
    for setting in learned:
        if setting.card["objective"] in ROLES:
            role = ROLES[setting.card["objective"]]
            rows.setdefault(model_title(setting, "hidden", "optimiser"), []).append((setting, role))
    if not rows:
        return None
    trivial = anchor(results, EXPERIMENT, TRIVIAL, test_set_of(learned[0].card))
    return dot_plot(
        list(rows.items()),
        METRICS,
        roles={f"{name} objective": role for name, role in ROLES.items()},
        reference=lambda metric: trivial.estimate(metric).median if trivial else None,
    )


FIGURES = (
    Figure(
        "forward_inverse",
        "Forward against inverse",
        "Each dot is a member, each bar the median of those that finished; failed members are counted at the right. "
        "Same nets, data, initialisation and budget.",
        "Dot plot: one row per network and optimiser, errors of force and of acceleration on logarithmic axes; filled "
        "dots are inverse fits, open squares forward ones.",
        draw,
    ),
)
