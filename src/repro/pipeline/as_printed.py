"""Whether a run is what the paper printed, or only something like it."""

from typing import Any

from repro.config.schema import Config, RandomForce

TABLE_I = {"m0": 0.6, "m1": 0.2, "L1": 0.5, "g": 9.8}
SECOND_ROD = {"m2": 0.2, "L2": 0.5}
DATA: dict[str, Any] = {
    "samples": 100_000,
    "train_fraction": 0.8,
    "train_samples": None,
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
FREE_EPOCHS, FINE_TUNING = 1000, 8000  # on D_H (not printed: those of the linear basis of V-A), then on D
FREE: dict[str, Any] = {"initial_angles": 100, "grid": "product", "steps": 10}


def is_literal(config: Config) -> bool:
    """Whether a run, at its scale, is a protocol as printed: V-A for the single pendulum, V-B for the double one.

    V-A.1: 100,000 points of 0.04 s under U(-5, 5), the first 80,000 for training; Keras Adam with learning rate 0.01,
    decay 1e-6 and batches of 2048; 1,000 epochs for T1 and for T2 with 2x500 softplus units. V-A.2: 5,000 epochs for
    the inverse model on T2 with 10 units. V-B.1: 10 points of free motion from each of 100x100 angles, then 8,000
    epochs on such data under U(-4, 4), on F (x) F with lambda_T = 1e-5. Start, reset and the epochs on D_H are as
    chosen for the paper's rows (paper/assumptions.yaml); the regime and the precision, not printed either, are free.
    The scale's name plays no part: whatever shortens a run is seen in its samples and epochs.
    """
    data, model, system = config.data, config.model.plain(), config.system
    if not isinstance(data, RandomForce) or model["kind"] != "lagrangian":
        return False
    if any(system.damping) or config.curriculum.episodes:
        return False
    if model["activation"] != "softplus" or model["initialisation"] != "glorot":
        return False
    if config.objective.momentum_weight or config.objective.error_scale or config.objective.l1_potential:
        return False
    return _single_pendulum(config, data) or _double_pendulum(config, data)


def _single_pendulum(config: Config, data: RandomForce) -> bool:
    hidden = () if config.basis.name == "t1" else config.model.plain()["hidden"]
    epochs = EPOCHS.get((config.basis.name, config.objective.kind, hidden))
    return (
        config.system.name == "sip"
        and config.system.constants == TABLE_I
        and config.sequence.kind == "main"
        and not config.objective.l1_kinetic
        and _agrees(data.model_dump(), DATA)
        and _agrees(config.optimiser.plain(), ADAM | {"epochs": epochs})
    )


def _double_pendulum(config: Config, data: RandomForce) -> bool:
    sequence, objective = config.sequence, config.objective
    last = FREE_EPOCHS if sequence.kind == "pretrain_only" else FINE_TUNING
    free = config.optimiser.length if sequence.pretraining_epochs is None else sequence.pretraining_epochs
    return (
        config.system.name == "dip"
        and config.system.constants == TABLE_I | SECOND_ROD
        and (config.basis.name, objective.kind, objective.l1_kinetic) == ("fxf", "inverse", 1e-5)
        and sequence.kind in ("pretrain_only", "pretrain")
        and free == FREE_EPOCHS
        and _agrees(sequence.model_dump(), FREE)
        and _agrees(data.model_dump(), DATA | {"force_limit": 4.0})
        and _agrees(config.optimiser.plain(), ADAM | {"epochs": last})
    )


def _agrees(options: dict[str, Any], printed: dict[str, Any]) -> bool:
    return all(options.get(key) == value for key, value in printed.items())
