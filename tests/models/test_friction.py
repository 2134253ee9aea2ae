"""Friction beside a learned Lagrangian, and encoders that are off: the same by every engine, and as in the plant."""

import casadi
import numpy as np
import pytest
import torch

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.bases import t1
from repro.models.damped import Damped
from repro.models.lagrangian import Lagrangian
from repro.models.model_options import Damping
from repro.models.zeroed import Zeroed

DRAW = np.random.default_rng(0)
Q, QD, QDD = (DRAW.normal(size=(6, 2)) for _ in range(3))
ENERGIES = [0.4, 0.025, 0.1, 0.98]


@pytest.mark.parametrize(
    ("damping", "own"),
    [
        ("diagonal", [0.3, 0.02]),
        ("coulomb", [0.3, 0.02, 0.5, 0.1]),
        ("offset", [0.3, 0.02, 0.5, 0.1, 0.7, -0.2]),
    ],
)
def test_friction_is_that_of_the_plant(damping: Damping, own: list[float]) -> None:
    model, weights = Damped(Lagrangian(t1, 2), damping), np.array([*ENERGIES, *own])
    plant = load("sip", damping=[0.3, 0.02], coulomb=own[2:4])
    tau = evaluate(dynamics_of(plant).inverse, Q, QD, QDD) + np.array(own[4:] or [0.0, 0.0])
    arrays = model.prepare(Q[None], QD[None], QDD[None], tau[None])
    prepared = {name: torch.from_numpy(array) for name, array in arrays.items()}
    np.testing.assert_allclose(
        model.evaluate(torch.from_numpy(weights)[None], prepared).tau[0].numpy(), tau, atol=1e-12
    )
    np.testing.assert_allclose(_inverse(model, weights), tau, atol=1e-12)
    assert (
        model.coefficient_names[4:]
        == tuple(f"{name}{i}" for name in ("c", "dry", "offset") for i in (0, 1))[: len(own)]
    )


def test_an_encoder_that_is_off_is_read_at_the_true_angle() -> None:
    model = Damped(Lagrangian(t1, 2), "diagonal")
    weights = np.array([*ENERGIES, 0.3, 0.02])
    shifted = _inverse(Zeroed(model, [1]), np.append(weights, 0.1), Q + np.array([0.0, 0.1]))
    np.testing.assert_allclose(shifted, _inverse(model, weights), atol=1e-12)


def _inverse(model: Damped | Zeroed, weights: np.ndarray, q: np.ndarray = Q) -> np.ndarray:
    symbols = [casadi.SX.sym(name, 2) for name in ("q", "qd", "qdd")]
    parameters = casadi.SX.sym("w", model.n_parameters)
    function = casadi.Function("inverse", [*symbols, parameters], [model.inverse_dynamics(*symbols, parameters)])
    return evaluate(function, q, QD, QDD, weights)
