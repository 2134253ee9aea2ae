"""Mechanisms of every kind learned from 1,000 exact samples, and a published recording of an arm."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import repro
from repro.mechanics.inputs import input_limits

ARM = Path(__file__).resolve().parents[3] / "shared" / "data" / "delan_characters.csv.gz"
WITH_ANGLES = (
    *("torque_pendulum", "acrobot", "pendubot", "furuta", "two_joint_arm"),
    *("ball_and_beam", "quadrotor", "cart_on_slope"),
)
TRANSLATIONS = ("ball_and_beam", "quadrotor", "spring_row", "cart_on_slope")


def learned(system: str, seed: int, model: str, iterations: int = 500, **options: object) -> pd.Series:
    """Errors on test data by metric."""
    data = repro.simulate(system, seeds=[seed], samples=1250, episode_steps=12, reset="random", force_limit=None)
    optimiser = repro.optimiser("levenberg_marquardt", iterations=iterations, damping_decrease=10.0)
    made = repro.model(model, **options)
    fitted = repro.fit(data, made, optimiser=optimiser, seeds=[seed], system=repro.system(system))
    return fitted.score(data)[seed]


def error(system: str, seed: int, model: str, **options: object) -> float:
    """MAE of tau as a share of the largest limit of an input."""
    return float(learned(system, seed, model, **options)["mae_tau"] / input_limits(repro.system(system)).max())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("system", WITH_ANGLES)
def test_a_structured_model_is_learned_from_a_thousand_samples(system, seed):
    assert error(system, seed, "structured") < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("system", TRANSLATIONS)
def test_a_network_for_all_positions_learns_what_depends_on_translations(system, seed):
    inertia = "positions" if system == "ball_and_beam" else "angles"
    assert error(system, seed, "neural_potential", iterations=1500, inertia=inertia, potential_hidden=[16]) < 1e-4


def test_the_energy_of_a_motor_with_its_rod_is_learned():
    """H = T + V, of the magnetic field and the rod: the antisymmetric forces between them have no energy.

    They fix its scale too: the rod has no input, and without them all its terms could be multiplied by a number.
    """
    found = learned("motor_pendulum", 0, "structured", damping="gyroscopic", hidden=[], skip=False)
    assert found["mae_H_centred"] < 1e-9 and found["mae_tau"] < 1e-9


@pytest.mark.slow
@pytest.mark.skipif(not ARM.is_file(), reason="the published recordings are not beside the checkout")
def test_the_arm_of_delan_is_learned_by_the_default_recipe():
    """Lutter, Ritter and Peters 2019: a vertical arm with two torques; its last characters are held out."""
    data = repro.dataset_from_frame(
        pd.read_csv(ARM), q=["q1", "q2"], qd=["q1d", "q2d"], qdd=["q1dd", "q2dd"], tau=["tau1", "tau2"],
        episode="char", angles=["q1", "q2"], time_step=0.04,
    )  # fmt: skip
    fitted = repro.fit(data, "structured", seeds=1)
    mean = np.abs(data.test.tau[0] - data.train.tau[0].mean(axis=0)).mean()
    assert fitted.score(data).loc["mae_tau", 0] < 1e-3 < mean / 100
