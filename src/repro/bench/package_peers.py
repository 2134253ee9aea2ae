"""Peers in their own packages: SINDy-PI of pysindy, and the pseudo-Hamiltonian network of phlearn."""

import contextlib
import io
from collections.abc import Callable

import numpy as np
import torch

from repro.bench.training_case import Step, TrainingCase, pendulum
from repro.learning.optimisers.basis_selection import Selection
from repro.learning.result import NoCheckpoint, silent
from repro.models.bases import library
from repro.models.lagrangian import Lagrangian

WEIGHT = 1e-4  # of SINDy-PI's l1 term: with more the error of qdd grows in proportion


def selection_fit(samples: int) -> Callable[[], np.ndarray]:
    """Our thresholded least squares over 35 candidates; the call evaluates them and returns the coefficients."""
    model = Lagrangian(library, 2)
    start = torch.zeros(1, model.n_parameters, dtype=torch.float64)
    problem = TrainingCase(model, start, pendulum([0], samples)).problem("inverse")

    def fit() -> np.ndarray:
        return np.asarray(Selection(threshold=0.02).fit(problem, start, silent, NoCheckpoint()).parameters[0])

    return fit


def sindy_pi_fit(samples: int) -> Callable[[], np.ndarray]:
    """SINDy-PI for both accelerations over 16 candidates, prepared beforehand; the call returns (2, candidate)."""
    import pysindy

    candidates = implicit_candidates(samples)

    def fit() -> np.ndarray:
        optimiser = pysindy.SINDyPI(reg_weight_lam=WEIGHT, model_subset=[0, 1], max_iter=20_000)
        with contextlib.redirect_stdout(io.StringIO()):  # it prints the number of each model
            optimiser.fit(candidates, candidates)
        return np.asarray(optimiser.coef_[:2])

    return fit


def implicit_candidates(samples: int) -> np.ndarray:
    """Candidate terms of implicit equations of the pendulum (sample, 16); the first two are the accelerations."""
    dataset = pendulum([0], samples)
    theta, (rate, force) = dataset.q[0, :, 1], (dataset.qd[0, :, 1], dataset.tau[0, :, 0])
    cos, sin, one = np.cos(theta), np.sin(theta), np.ones_like(theta)
    moving = [part * dataset.qdd[0, :, c] for part in (one, cos, sin) for c in (0, 1)]
    rest = [rate**2 * sin, rate**2 * cos, sin, cos, sin * cos, dataset.qd[0, :, 0], rate, force, force * cos, one]
    return np.stack([*moving, *rest], axis=1)


def phlearn_step(case: TrainingCase) -> Step:
    """Loss on the rates of a state and its gradient; a network of 2 x 64 units for H, S known, no friction, float32."""
    from phlearn.phnns import HamiltonianNN, PseudoHamiltonianNN

    n_q = case.dataset.n_q
    zero, one, friction = np.zeros((n_q, n_q)), np.eye(n_q), np.zeros((2 * n_q, 2 * n_q))
    torch.manual_seed(0)
    network, interconnection = HamiltonianNN(2 * n_q, hidden_dim=64), np.block([[zero, one], [-one, zero]])
    model = PseudoHamiltonianNN(2 * n_q, interconnection, dissipation_true=friction, hamiltonian_est=network)
    state = torch.cat([case.measured("q")[0], case.measured("qd")[0]], dim=-1).to(model.ttype)
    rate = torch.cat([case.measured("qd")[0], case.measured("qdd")[0]], dim=-1).to(model.ttype)
    weights, time = list(network.parameters()), torch.zeros(len(state), 1, dtype=model.ttype)

    def step() -> tuple[np.ndarray, np.ndarray]:
        loss = (model.time_derivative(False, state, state, time, time, 0.0) - rate).square().mean()
        # the last bias shifts H alone
        gradients = torch.autograd.grad(loss, weights, allow_unused=True, materialize_grads=True)
        return loss.detach().numpy(), torch.cat([gradient.flatten() for gradient in gradients]).numpy()

    return step
