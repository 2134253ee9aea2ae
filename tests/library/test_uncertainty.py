"""Standard errors of a fit against their closed form, and what they say of the predicted force."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import nn

import repro
from repro.errors import UserError

NOISE, TRUE = 0.1, np.array([0.4, 0.025, 0.1, 0.98])  # N; (m0 + m1) / 2, m1 L1^2 / 2, m1 L1, m1 g L1


@pytest.fixture(scope="module")
def fitted():
    data = repro.simulate("sip", samples=600, reset="random", episode_steps=40, seeds=20, tau_noise=NOISE)
    return repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares", seeds=20)


def test_standard_errors_are_those_of_a_regression(fitted):
    """sqrt diag (J' S^-1 J)^-1 with the variance of each component's residuals in S."""
    train, first = fitted.data.train, fitted.member(0)
    alone = [replace(first, weights_=weights[None]) for weights in np.eye(4)]
    columns = np.stack([each.tau(train.q[0], train.qd[0], train.qdd[0])[0] for each in alone], axis=-1)
    residual = first.tau(train.q[0], train.qd[0], train.qdd[0])[0] - train.tau[0]
    variance = (residual**2).sum(0) / (train.samples - 2)
    information = np.einsum("siw,siv,i->wv", columns, columns, 1 / variance)
    expected = np.sqrt(np.linalg.inv(information).diagonal())
    np.testing.assert_allclose(first.uncertainty().standard_errors[0], expected, rtol=1e-8)


def test_the_true_weights_lie_within_them(fitted):
    """80 standardised errors: their root mean square is 1 within four of its own standard deviations."""
    errors = fitted.uncertainty().standard_errors
    scores = (fitted.weights_ - TRUE) / errors
    assert errors.shape == (20, 4)
    assert abs(np.sqrt((scores**2).mean()) - 1) < 4 / np.sqrt(2 * scores.size)


def test_the_predicted_force_is_as_uncertain_as_the_weights_make_it(fitted):
    known = fitted.uncertainty()
    q, qd, qdd = np.array([[0.0, 0.4], [0.1, 2.0]]), np.array([[1.0, 1.0], [0.5, -2.0]]), np.array([[1.0, 0.0]] * 2)
    deviation = known.tau(q, qd, qdd)
    spread = fitted.tau(q, qd, qdd).std(0, ddof=1)
    assert deviation.shape == (20, 2, 2)
    np.testing.assert_allclose(spread, deviation.mean(0), rtol=0.5)  # 20 draws know a deviation within 16 %


def test_its_table_names_weights_and_seeds(fitted):
    table = fitted.uncertainty().table
    assert list(table.index) == list(fitted.model.coefficient_names)
    assert table.shape == (4, 40)
    assert table[(3, "value")].to_list() == fitted.weights_[3].tolist()


def test_what_the_data_do_not_determine_has_no_standard_error():
    """At rest T plays no part: only the weight of cos(theta) is known."""
    q = np.linspace(-1, 1, 50)[:, None] * [[0.0, 1.0]]
    tau = np.stack([np.zeros(50), -0.98 * np.sin(q[:, 1])], axis=1)
    zero, rng = np.zeros_like(q), np.random.default_rng(3)
    data = repro.dataset(
        q, zero, tau + 0.01 * rng.normal(size=tau.shape), qdd=zero, time_step=0.1, coordinates=["x", "theta"],
        angles=["theta"],
    )  # fmt: skip
    errors = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares").uncertainty().standard_errors[0]
    assert np.isinf(errors[:3]).all()
    assert errors[3] < 0.02


class Accelerations(nn.Module):
    def __init__(self):
        super().__init__()
        self.net = nn.Linear(3, 1)

    def forward(self, q, qd, tau):
        return self.net(torch.cat([q, qd, tau], dim=-1))


def test_a_model_without_forces_has_no_uncertainty_of_them():
    data = repro.simulate("link", samples=60, reset="random", episode_steps=20)
    fitted = repro.fit(data, Accelerations, objective="forward", optimiser=repro.optimiser("lbfgs", iterations=1))
    with pytest.raises(UserError, match="predicts no tau"):
        fitted.uncertainty()
