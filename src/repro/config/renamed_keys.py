"""Keys and options that had another name in version 0.1."""

from repro.errors import UserError

KEYS = {
    "control.hard": "control.obstacle_constraint",
    "control.later_intervals": "control.coarse_intervals",
    "control.later_step": "control.coarse_step",
    "control.margin": "control.clearance_radii",
    "control.penalty": "control.obstacle_weight",
    "control.running": "control.stage_cost",
    "control.terminal": "control.terminal_cost",
    "data.shared": "data.common",
    "energies.reading": "energies.gauge",
    "model.transform_hidden": "model.momentum_hidden",
    "objective.finish": "objective.equal_weight_share",
    "objective.transform_weight": "objective.momentum_weight",
    "optimiser.decrease": "optimiser.damping_decrease",
    "optimiser.nearest_to": "optimiser.regularise_towards",
    "optimiser.scouting": "optimiser.trial_iterations",
    "optimiser.starts": "optimiser.restarts",
    "scale.starts": "scale.initial_angles",
    "sequence.free_epochs": "sequence.pretraining_epochs",
    "sequence.starts": "sequence.initial_angles",
    "task.starts": "task.initial_states",
}
OPTIONS = {
    ("sequence", "anchor"): "anchored",
    ("sequence", "d_h_only"): "pretrain_only",
    ("sequence", "d_h_then_d"): "pretrain",
    ("sequence", "d_only"): "main",
    ("system", "pendulum"): "cart_rods",
}


def refuse_renamed(override: str) -> None:
    """UserError with the present name where an override uses one of version 0.1."""
    key, _, value = override.lstrip("+~").partition("=")
    for old, new in KEYS.items():
        if key == old or key.startswith(f"{old}."):
            raise UserError(f"{override}: {old} is called {new} now; write {override.replace(old, new, 1)}")
    for word in value.split(","):
        if (key, word) in OPTIONS:
            raise UserError(f"{override}: {key}={word} is called {key}={OPTIONS[key, word]} now")
