"""Pretraining on D_H: every member's errors after each sequence, and the learning curves of both phases."""

from typing import TYPE_CHECKING

from repro.report import style
from repro.report.figures.curves import curve_panels
from repro.report.figures.dots import dot_plot
from repro.report.figures.figure import Figure
from repro.report.style import Role
from repro.report.tables.paired import epochs_in_all, pairs
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import TRIVIAL, anchor, settings, test_set_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

NEEDS = ("pretraining_epochs",)
EXPERIMENT = "dip_pretraining"
APART = ("grid", "pretraining_epochs", "epochs")  # what a pair of equal budgets may differ in
METRICS = {"mae_tau": "N, N m", "mae_L_raw": "J", "mae_H_centred": "J"}
PRINTED = {"mae_tau": 0.10, "mae_L_raw": 12.35}
ROLES = {"pretrain": style.SERIES[0], "main": style.SERIES[1], "pretrain_only": style.SERIES[2]}
LABELS = {"pretrain": "D_H, then D", "main": "D alone", "pretrain_only": "D_H alone"}


def draw_errors(results: Results) -> "Canvas | None":
    """Draw one row per optimiser and budget, with the sequences in it."""
    rows: dict[str, list[tuple[RunSetting, Role]]] = {}
    candidates = [s for s in settings(results, EXPERIMENT) if s.card["sequence"] in ROLES and _counts_epochs(s)]
    for setting in sorted(candidates, key=_place):
        rows.setdefault(_title(setting), []).append((setting, ROLES[setting.card["sequence"]]))
    if not rows:
        return None
    trivial = anchor(results, EXPERIMENT, TRIVIAL, test_set_of(candidates[0].card))
    return dot_plot(
        list(rows.items()),
        METRICS,
        roles={LABELS[sequence]: role for sequence, role in ROLES.items()},
        printed=PRINTED,
        reference=lambda metric: trivial.estimate(metric).median if trivial and metric == "mae_tau" else None,
    )


def draw_curves(results: Results) -> "Canvas | None":
    """Draw one panel per pair of equal budgets: pretrained and not."""
    panels: dict[str, list[tuple[str, RunSetting]]] = {}
    for pretrained, alone in pairs(results, EXPERIMENT, {"sequence": "pretrain"}, {"sequence": "main"}, APART, NEEDS):
        panels[_title(pretrained).replace(", ", "\n", 1)] = [
            (LABELS["pretrain"], pretrained),
            (LABELS["main"], alone),
        ]
    roles = {LABELS[sequence]: ROLES[sequence] for sequence in ("pretrain", "main")}
    return curve_panels(results, panels, roles)


def _title(setting: RunSetting) -> str:
    card = setting.card
    regime = "one long run" if card["regime"] == "long" else "episodes"
    return f"{regime}, {setting.title('optimiser').removesuffix(' + L1')}, {epochs_in_all(setting)} epochs"


def _counts_epochs(setting: RunSetting) -> bool:
    # The others end at rounding, from any start: drawn beside these they would flatten them.
    return setting.card["optimiser"].startswith("adam")


def _place(setting: RunSetting) -> tuple[str, str, int]:
    card = setting.card
    return card["regime"], card["optimiser"], epochs_in_all(setting)


FIGURES = (
    Figure(
        "dip_pretraining",
        "The double pendulum: pretraining on D_H",
        "Each dot is a member, each bar the median, errors on the test part of D; the same number of epochs in a row."
        " The paper prints 0.10 and 12.35 for D_H, then 8,000 epochs on D.",
        "Dot plot: one row per regime and optimiser, one panel per metric, logarithmic, and what is printed.",
        draw_errors,
    ),
    Figure(
        "learning_curves_pretraining",
        "Learning curves: pretraining on D_H, then D, against D alone",
        "The same initialisation and number of epochs. The loss of the first phase is that of D_H, so the jump is "
        "where D begins. Thin lines are members, the thick one their median.",
        "One panel per regime and optimiser: loss over steps with and without pretraining; the pretrained one jumps "
        "where D begins.",
        draw_curves,
    ),
)
