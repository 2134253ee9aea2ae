"""The README's table of models: what the same data give, from doing nothing to the closed form."""

from repro.report import writing
from repro.report.model_tables import anchor_title
from repro.report.results import Results
from repro.report.selection import anchor_name, settings
from repro.report.setting import Setting
from repro.report.vocabulary import metric_named

EXPERIMENT = "sip_regimes"
WHERE = {"regime": "episodes", "episode_steps": 1000, "labels": "exact", "tau_noise": 0.0}
METRICS = ("mae_tau", "mae_qdd", "mae_H_centred", "mae_L_canonical", "fit_seconds")


def models_block(results: Results) -> str:
    """Return one line a model, worst first: medians of its errors over the members, and seconds a member."""
    found = sorted(settings(results, EXPERIMENT, WHERE), key=lambda setting: -setting.estimate("mae_tau").median)
    titles = ["model", *(metric_named(metric).label for metric in METRICS), "members"]
    lines = [f"| {' | '.join(titles)} |", f"|{' --- |' * len(titles)}"]
    for setting in found:
        medians = [setting.estimate(metric) for metric in METRICS]
        cells = (_title(setting), *(writing.number(one.median) for one in medians), str(setting.n))
        lines.append(f"| {' | '.join(writing.markdown(cell) for cell in cells)} |")
    return "\n".join(lines)


def _title(setting: Setting) -> str:
    name = anchor_name(setting)
    if name is not None:
        return anchor_title(name, setting.card["basis"])
    first = "basis" if setting.card["model"] == "lagrangian" else "model"
    title = setting.title(first, "hidden", "optimiser")
    return f"{title}, {setting.card['epochs']} epochs" if setting.card["optimiser"] == "adam" else title
