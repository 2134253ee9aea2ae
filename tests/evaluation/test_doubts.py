"""A bad fit is called one, and a good fit is not."""

import numpy as np
import pytest

from repro.data.dataset import Dataset
from repro.evaluation.doubts import doubts, mean_predictor
from repro.evaluation.pointwise import MetricValues
from repro.mechanics.coordinate import Coordinate


def data() -> Dataset:
    """Forces 0 and 2 in training, 3 in the test, so that their mean errs by 2."""
    tau = np.array([0.0, 2.0, 3.0, 3.0]).reshape(1, 4, 1)
    return Dataset(
        q=tau, qd=tau, qdd=tau, tau=tau, time=np.arange(4.0), episode=np.zeros(4, dtype=int), n_train=2,
        coordinates=(Coordinate("x", "m", is_angle=False),), time_step=1.0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("mae_tau", [1.9], ""),
        ("mae_tau", [2.0], "the force is predicted no better than by its mean: mae_tau 2 against 2"),
        ("mae_tau", [0.1, 5.0, np.nan], "(2 of 3 members)"),
        ("mae_qdd", [np.inf], "the acceleration is predicted no better"),
        ("min_eig_M", [1e-9], ""),
        ("min_eig_M", [0.1, -0.02], "not positive definite: least eigenvalue -0.02 (1 of 2 members)"),
    ],
)
def test_a_doubt_is_one_line(name: str, values: list[float], said: str) -> None:
    lines = [*doubts([MetricValues("test", name, np.array(values), "1")], data())]
    assert len(lines) == bool(said)
    assert said in "".join(lines)


def test_the_mean_predictor_takes_the_mean_of_the_training_part() -> None:
    assert mean_predictor(data(), "tau").tolist() == [2.0]
