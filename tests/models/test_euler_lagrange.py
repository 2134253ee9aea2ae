"""The residual of a network without a Hessian, against its definition."""

import casadi
import numpy as np
import pytest
import torch

from repro.codegen.array_evaluation import evaluate
from repro.models.bases import engineered, raw
from repro.models.lagrangian import Lagrangian

SAMPLES = 9


@pytest.mark.parametrize("basis", [raw, engineered])
@pytest.mark.parametrize("n_q", range(1, 9))
def test_networks_of_features_agree_with_the_definition_in_symbols(basis, n_q):
    model = Lagrangian(basis, n_q, hidden=(5, 4))
    parameters = torch.from_numpy(model.initial([np.random.default_rng(0), np.random.default_rng(1)]))
    samples = np.random.default_rng(2).normal(size=(4, 2, SAMPLES, n_q))
    prepared = {name: torch.from_numpy(array) for name, array in model.prepare(*samples).items()}
    ours = model.evaluate(parameters, prepared).tau.numpy()
    q, qd, qdd, theta = (
        casadi.SX.sym(x, n) for x, n in [("q", n_q), ("v", n_q), ("a", n_q), ("w", len(parameters[0]))]
    )
    tau = casadi.Function("tau", [q, qd, qdd, theta], [model.inverse_dynamics(q, qd, qdd, theta)])
    weights = np.repeat(parameters.numpy()[:, None], SAMPLES, axis=1)
    np.testing.assert_allclose(ours, evaluate(tau, *samples[:3], weights), rtol=1e-10, atol=1e-10)
