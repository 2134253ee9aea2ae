"""Whether a run is what the paper printed, or only something like it."""

from typing import Any

from repro.config import Config, RandomForce

TABLE_I = {"m0": 0.6, "m1": 0.2, "L1": 0.5, "g": 9.8}
DATA: dict[str, Any] = {
    "samples": 100_000,
    "train_fraction": 0.8,
    "time_step": 0.04,
    "force_limit": 5.0,
    "start": "upright",
    "reset": "start",
    "labels": "exact",
    "tau_noise": 0.0,
    "qdd_noise": 0.0,
    "q_noise": 0.0,
    "qd_noise": 0.0,
}
ADAM: dict[str, Any] = {
    "kind": "adam",
    "schedule": "keras",
    "learning_rate": 0.01,
    "decay": 1e-6,
    "epsilon": 1e-7,
    "batch_size": 2048,
}
# (basis, objective, units of the hidden layers) -> epochs; T1 is linear, whatever the units.
EPOCHS: dict[tuple[str, str, tuple[int, ...]], int] = {
    ("t1", "forward", ()): 1000,
    ("t1", "inverse", ()): 1000,
    ("t2", "forward", (500, 500)): 1000,
    ("t2", "inverse", (10,)): 5000,
}


def is_literal(config: Config) -> bool:
    """Whether a run, at its scale, is the single pendulum's protocol as printed in V-A.1 and V-A.2.

    V-A.1: 100,000 points of 0.04 s under U(-5, 5), the first 80,000 for training; Keras Adam with learning rate 0.01,
    decay 1e-6 and batches of 2048; 1,000 epochs for T1 and for T2 with 2x500 softplus units. V-A.2: 5,000 epochs for
    the inverse model on T2 with 10 units. Start and reset are as chosen for the paper's rows (paper/assumptions.yaml);
    the regime and the precision, which are not printed either, are free.
    The scale's name plays no part: whatever shortens a run is seen in its samples and epochs.
    """
    data, model = config.data, config.model
    if not isinstance(data, RandomForce) or model["kind"] != "lagrangian" or config.sequence.kind != "d_only":
        return False
    system = config.system
    if system.name != "sip" or system.constants != TABLE_I or any(system.damping) or config.curriculum.episodes:
        return False
    if model["activation"] != "softplus" or model["initialisation"] != "glorot":
        return False
    objective = config.objective
    extras = (objective.transform_weight, objective.l1_kinetic, objective.l1_potential, objective.error_scale)
    hidden = () if config.basis.name == "t1" else tuple(model["hidden"])
    epochs = EPOCHS.get((config.basis.name, objective.kind, hidden))
    return not any(extras) and _agrees(data.model_dump(), DATA) and _agrees(config.optimiser, ADAM | {"epochs": epochs})


def _agrees(options: dict[str, Any], printed: dict[str, Any]) -> bool:
    return all(options.get(key) == value for key, value in printed.items())
