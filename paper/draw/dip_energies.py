"""What fixes the energies of the double pendulum in closed form, every member shown."""

from typing import TYPE_CHECKING

from repro.report import style
from repro.report.figures.dots import dot_plot
from repro.report.figures.figure import Figure
from repro.report.style import Role
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import anchor_name, settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "dip_identifiability"
METRICS = {"mae_H_sum": "J", "mae_H_legendre": "J", "mae_H_centred": "J"}
ROLES = {
    "exact forces": style.SERIES[0],
    "force noise 0.1 N": style.SERIES[1],
    "exact forces, from a random start": style.SERIES[2],
}
SEQUENCES = ("main", "anchor", "pretrain_only", "pretrain", "joint")


def draw(results: Results) -> "Canvas | None":
    """Draw one row per sequence on F⊗F with gauge terms."""
    rows: dict[str, list[tuple[RunSetting, Role]]] = {}
    for sequence in SEQUENCES:
        for setting in settings(results, EXPERIMENT, {"basis": "fxf_gauge", "sequence": sequence}):
            if anchor_name(setting) is None:
                title = "one anchor" if sequence == "anchor" else written("sequence", sequence)
                rows.setdefault(title, []).append((setting, ROLES[_kind(setting)]))
    return dot_plot(list(rows.items()), METRICS, roles=ROLES) if rows else None


def _kind(setting: RunSetting) -> str:
    if setting.card["optimiser"].endswith("from_start"):
        return "exact forces, from a random start"
    return "force noise 0.1 N" if setting.card["tau_noise"] else "exact forces"


FIGURES = (
    Figure(
        "dip_energies",
        "Energies of the double pendulum",
        "Closed form on F⊗F with gauge terms: T + V as printed, the Legendre energy, and the latter up to one "
        "constant. Forces say nothing of the gauge; one known energy fixes one number; D_H fixes all but what "
        "vanishes with the momentum of the cart, which stays where the fit started.",
        "Dot plot: one row per sequence of data, one panel per energy error, logarithmic.",
        draw,
    ),
)
