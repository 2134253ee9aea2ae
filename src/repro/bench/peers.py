"""Public peers on the same data and machine, each through its own package; those not installed are left out."""

import contextlib
import io
from collections.abc import Callable, Iterator
from functools import partial
from importlib.metadata import PackageNotFoundError, version

import numpy as np
import torch

from repro.bench.contender import PREPARED, Contender, compared, fastest
from repro.bench.control import control
from repro.bench.framework_peers import jax_batched_step, jax_step, torch_compiled_step
from repro.bench.pairing import PairedComparison, Pairs, with_memory
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import Precision, Step, TrainingCase, pendulum
from repro.codegen.c_library import has_compiler
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


BATCHED = "; batched, one tangent forward and one pass back written out, derivatives of the features prepared for both"
JAX = "; JAX {version}, jit and vmap over samples and members, XLA with one thread"
PHLEARN = "; phlearn {version}: a pseudo-Hamiltonian network of equal width, loss on the rates of the state"
PYSINDY = (
    "processor time of finding the single pendulum's equation from {batch} samples, candidates prepared beforehand; "
    "one thread; in turn, {{pairs}} pairs; pysindy {version}: both accelerations, l1 weight 1e-4, which leaves an "
    "error of qdd below 1e-6; ours has the terms and coefficients of L to rounding"
)
WIDE = (64, 64)


def peers(scale: BenchScale) -> Iterator[PairedComparison]:
    """Comparisons with torch.compile and with the installed packages."""
    if scale.compile_torch and has_compiler():
        yield from _batched(scale, "torch.compile", torch_compiled_step)
    for package, compare in PEERS.items():
        if installed := _version(package):
            yield from compare(scale, installed)


def missing() -> list[str]:
    """Names of the packages that are not installed."""
    return [package for package in PEERS if _version(package) is None]


def _jax(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    """Steps of the inverse model against the LNN as published, and against our own formulation."""
    ways = [
        Contender("JAX, LNN (Hessian and solve)", partial(jax_step, equation="forward")),
        Contender("JAX, inverse (jvp of grad)", partial(jax_step, equation="inverse")),
    ]
    for hidden, members in [*((hidden, 1) for hidden in scale.sizes), (PAPER_HIDDEN, scale.ensemble)]:
        for other in ways:
            remark = PREPARED + JAX.format(version=version)
            yield compared(scale, "peers", hidden, fastest("inverse"), other, remark, members=members)
    yield from _batched(scale, f"JAX {version}, jit", jax_batched_step)


def _batched(scale: BenchScale, label: str, step: Callable[..., Step]) -> Iterator[PairedComparison]:
    """One network in both precisions against the strongest form that a framework can be given."""
    precisions: tuple[Precision, ...] = ("float64", "float32")
    for hidden in (scale.sizes[0], scale.sizes[-1]):
        for precision in precisions:
            other = Contender(f"{label}, batched, {precision}", partial(step, precision=precision))
            ours = fastest("inverse", precision)
            yield compared(scale, "peers", hidden, ours, other, BATCHED, precision=precision)


def _phlearn(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    other, remark = Contender("phlearn, network for H", phlearn_step), PREPARED + PHLEARN.format(version=version)
    yield compared(scale, "peers", WIDE, fastest("inverse", "float32"), other, remark, precision="float32")


def _pysindy(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    def measure() -> Pairs:
        return with_memory(selection_fit(scale.batch), sindy_pi_fit(scale.batch), scale.rounds)

    protocol = PYSINDY.format(batch=scale.batch, version=version)
    labels = "thresholded least squares", "pysindy, SINDy-PI", "35 | 16 terms"
    yield PairedComparison("peers", *labels, 1, protocol, measure)


PEERS = {"jax": _jax, "phlearn": _phlearn, "pysindy": _pysindy, "do-mpc": control}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
