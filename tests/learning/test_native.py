"""Generated code against torch: two independent derivations of the same loss, gradient and Jacobian."""

from contextlib import nullcontext

import numpy as np
import pytest
import torch
from compilation import unoptimised
from optional import needs_compiler
from tensors import assert_close

from repro.codegen import lanes
from repro.codegen.c_library import CompilerError
from repro.codegen.lanes import LANES, can_compile
from repro.learning import native as module
from repro.learning.kernels.generated import generated_kernel, normal_equations
from repro.learning.kernels.kernel import Evaluations
from repro.learning.kernels.network_kernel import network_kernel
from repro.learning.kernels.positions import position_kernel
from repro.learning.members import MemberProblem
from repro.learning.native import NativeProblem, native
from repro.learning.objective import Objective
from repro.learning.objectives import forward, inverse, port
from repro.learning.optimisers.adam import Adam
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import raw, t1, t2
from repro.models.kinds import blackbox, port_hamiltonian, structured
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian

pytestmark = needs_compiler

SCALE = np.array([0.9, 5.0])
MODELS = {
    "t1": lambda: Lagrangian(t1, 2),
    "t2": lambda: Lagrangian(t2, 2, hidden=(4,)),
    "t2 deep": lambda: Lagrangian(t2, 2, hidden=(11, 4, 5), activation="tanh"),
    "raw": lambda: Lagrangian(raw, 2, hidden=(25, 3)),
    "structured": lambda: Structured(2, np.array([0.9, 5.0]), structured.Options(hidden=(2,))),
    "structured deep": lambda: Structured(
        2, np.array([0.9, 5.0]), structured.Options(hidden=(3, 9), activation="softplus", skip=False)
    ),
    "transformed": lambda: Lagrangian(t1, 2, momentum_hidden=(2,)),
    "port": lambda: PortHamiltonian(Lagrangian(t1, 2), SCALE, port_hamiltonian.Options(damping_hidden=(2,))),
    "blackbox": lambda: BlackBox(2, blackbox.Options(hidden=(3,))),
    "blackbox, large": lambda: BlackBox(2, blackbox.Options(hidden=(24, 12))),
}
INVERSE, FORWARD = Objective(inverse.Options()), Objective(forward.Options())
ANCHOR = Objective(None, energy_weight=0.7, energy_form="sum")
CASES = {
    "t1 inverse": ("t1", [INVERSE]),
    "t1 forward": ("t1", [FORWARD]),
    "t1 joint": ("t1", [INVERSE, Objective(inverse.Options(), energy_weight=0.4)]),
    "t2 inverse": ("t2", [INVERSE]),
    "t2 deep inverse": ("t2 deep", [INVERSE]),
    "t2 deep forward": ("t2 deep", [FORWARD]),
    "t2 deep, energy as sum": ("t2 deep", [ANCHOR]),
    "raw, forward and joint": ("raw", [FORWARD, Objective(forward.Options(), energy_weight=0.4)]),
    "t2 forward": ("t2", [FORWARD]),
    "structured inverse": ("structured", [INVERSE]),
    "structured forward": ("structured", [FORWARD]),
    "structured deep, joint": ("structured deep", [INVERSE, Objective(inverse.Options(), energy_weight=0.4)]),
    "structured deep, energy as sum": ("structured deep", [ANCHOR]),
    "momentum transform": ("transformed", [Objective(inverse.Options(momentum_weight=0.3))]),
    "port form, where no weight changes the rates of q": ("port", [Objective(port.Options())]),
    "black box": ("blackbox", [FORWARD]),
    "black box, large": ("blackbox, large", [FORWARD]),
    "energy as sum, alone": ("t2", [ANCHOR]),
    "joint with the Legendre energy": ("t2", [INVERSE, Objective(inverse.Options(), energy_weight=0.4)]),
}
# Of kernels that the other cases compile with all optimisations.
REPEATED = (
    *("t2 deep forward", "t2 deep, energy as sum", "raw, forward and joint", "structured deep, joint"),
    *("energy as sum, alone", "joint with the Legendre energy"),
)


def _compiled(name):
    return unoptimised() if name in REPEATED else nullcontext()


@pytest.fixture(params=CASES)
def case(request, data, free):
    name, objectives = CASES[request.param]
    with _compiled(request.param):
        yield _problem(MODELS[name](), objectives, data, free)


def _problem(model, objectives, data, free):
    """The last task is on D_H where its energy is asked for; its samples, and those of D, fill no whole lanes."""
    chosen = [free if objective.energy_weight else data for objective in objectives]
    scale = 20.0 if len(objectives) == 1 else None  # sample weights
    tasks = [make_task(model, d.train, o, error_scale=scale) for d, o in zip(chosen, objectives, strict=True)]
    l1 = torch.linspace(0, 0.1, model.n_parameters, dtype=torch.float64) if model.n_parameters == 4 else None
    return TrainingProblem(model, tasks, [0, 1, 2], l1)


def _close(ours, expected):
    np.testing.assert_allclose(ours, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


def test_loss_and_gradient_agree(case, start):
    parameters = start(case.model).requires_grad_()
    losses = case.loss(parameters)
    (gradients,) = torch.autograd.grad(losses.sum(), parameters)
    assert case.samples % LANES
    kernels = [make(case) for make in (generated_kernel, network_kernel, position_kernel)]
    for kernel in filter(None, kernels):
        compiled = NativeProblem(case, kernel)
        for member in range(case.members):
            loss, gradient = compiled.loss_and_gradient(member, parameters[member].detach().numpy().copy())
            _close(loss, losses[member].item())
            _close(gradient, gradients[member].numpy())


NETWORKS = [name for name, (model, _) in CASES.items() if model in ("t2", "t2 deep", "raw")]


@pytest.mark.parametrize("name", NETWORKS)
def test_single_precision_comes_as_close_as_its_digits_allow(name, data, free, start):
    """Rounding is 6e-8; near a singular mass matrix more comes of it, and as much in torch."""
    problem = _problem(MODELS[CASES[name][0]](), CASES[name][1], data, free)
    with _compiled(name):
        single = native(problem, np.float32)
    assert single.data[0].dtype == np.float32
    weights = start(problem.model)
    exact, rounded = _of_torch(problem, weights), _of_torch(problem.cast(torch.float32), weights.float())
    for member in range(problem.members):
        loss, gradient = single.loss_and_gradient(member, weights[member].float().numpy())
        assert gradient.dtype == np.float32
        ours = np.array([loss, *gradient])
        of_torch = np.linalg.norm(rounded[member] - exact[member])
        allowed = max(10 * of_torch, 1e-4 * np.linalg.norm(exact[member]))
        assert np.linalg.norm(ours - exact[member]) <= allowed


def _of_torch(problem, weights):
    """Loss and gradient (member, 1 + n_parameters)."""
    leaves = weights.clone().requires_grad_()
    losses = problem.loss(leaves)
    (gradients,) = torch.autograd.grad(losses.sum(), leaves)
    return torch.cat([losses.unsqueeze(1), gradients], dim=1).detach().double().numpy()


def test_only_networks_of_features_have_a_kernel_for_single_precision(data):
    assert native(_problem(Lagrangian(t1, 2), [INVERSE], data, None), np.float32) is None


def test_normal_equations_agree(case, start):
    parameters = start(case.model)
    member = case.member(1)
    rows, jacobian = (part[0].numpy() for part in member.linearise(parameters[1:2]))
    ours, weights = MemberProblem(member), parameters[1].numpy().copy()
    assert (ours.sums is None) == (generated_kernel(member) is None)
    gram, gradient = ours.normal_equations(weights)
    _close(gram, jacobian.T @ jacobian)
    _close(gradient, jacobian.T @ rows)
    assert ours.loss(weights) == pytest.approx(rows @ rows, rel=1e-12)


@pytest.mark.slow
def test_large_models_of_expressions_are_compiled_where_they_are_linearised_often(data, start):
    """More than 400 weights, which CasADi would differentiate sample by sample."""
    options = port_hamiltonian.Options(structure="full", damping_hidden=(14,))
    problem = _problem(PortHamiltonian(Lagrangian(t1, 2), SCALE, options), [Objective(port.Options())], data, None)
    member, weights = problem.member(0), start(problem.model)[:1]
    assert normal_equations(member, Evaluations(100, 1000)) is None
    compiled = normal_equations(member, Evaluations(1000, 1000))
    rows, jacobian = (part[0].numpy() for part in member.linearise(weights))
    gram, gradient = compiled.normal_equations(weights[0].numpy())
    _close(gram, jacobian.T @ jacobian)
    _close(gradient, jacobian.T @ rows)
    assert compiled.loss(weights[0].numpy()) == pytest.approx(rows @ rows, rel=1e-12)


def test_weights_that_are_exactly_zero_leave_softplus_its_curvature(data, start):
    """Raw coordinates at the upright rest are all zero, and so are fresh biases: every unit is at 0 there."""
    model = Lagrangian(raw, 2, hidden=(3,))
    parameters = model.initial([np.random.default_rng(0)] * 3)
    assert np.all(data.q[0, 0] == 0) and np.all(data.qd[0, 0] == 0)
    for objective in (INVERSE, FORWARD):
        problem = _problem(model, [objective], data, None)
        expected = problem.loss(torch.from_numpy(parameters))[0].item()
        assert native(problem).loss_and_gradient(0, parameters[0])[0] == pytest.approx(expected, rel=1e-11)


JOINT = [INVERSE, Objective(inverse.Options(), energy_weight=0.4)]


@pytest.mark.parametrize(
    ("objectives", "precision", "close"),
    [([FORWARD], "float64", 1e-10), (JOINT, "float64", 1e-10), (JOINT, "float32", 1e-4)],
)
def test_adam_takes_the_same_steps_in_both_engines(objectives, precision, close, data, free, start):
    problem = _problem(MODELS["t2"](), objectives, data, free)
    parameters = start(problem.model)
    fits = [
        Adam(epochs=3, batch_size=32, engine=engine, precision=precision).fit(
            problem, parameters, silent, NoCheckpoint()
        )
        for engine in ("auto", "torch")
    ]
    assert fits[0].parameters.dtype == fits[1].parameters.dtype == getattr(torch, precision)
    assert not torch.equal(fits[0].parameters, parameters)
    assert_close(fits[0].parameters, fits[1].parameters, rtol=close, atol=close)
    for (step, name, values), (other_step, other_name, others) in zip(*(fit.curves for fit in fits), strict=True):
        assert (step, name) == (other_step, other_name)
        np.testing.assert_allclose(values, others, rtol=close)


def test_without_a_compiler_torch_gives_the_same_result(data, start, monkeypatch):
    problem = _problem(MODELS["t2"](), [INVERSE], data, None)
    parameters = start(problem.model)
    optimisers = [Adam(epochs=3, batch_size=50), LevenbergMarquardt(restarts=1, iterations=5)]
    compiled = [optimiser.fit(problem, parameters, silent, NoCheckpoint()).parameters for optimiser in optimisers]
    monkeypatch.setattr(module, "can_compile", lambda: False)
    assert native(problem) is None
    for optimiser, expected in zip(optimisers, compiled, strict=True):
        ours = optimiser.fit(problem, parameters, silent, NoCheckpoint()).parameters
        assert_close(ours, expected, rtol=1e-9, atol=1e-9)


def test_a_compiler_that_cannot_compile_counts_as_none(monkeypatch):
    def refuse(source, flags):
        raise CompilerError("math.h: no such file")

    monkeypatch.setattr(lanes, "load_library", refuse)
    can_compile.cache_clear()
    assert not can_compile()
    monkeypatch.undo()
    can_compile.cache_clear()
    assert can_compile()


KERNELS = {
    "t1": (generated_kernel, Lagrangian(t1, 2)),
    "t2": (network_kernel, Lagrangian(t2, 2, hidden=(150, 40))),
    "structured": (position_kernel, Structured(2, np.array([0.9, 5.0]), structured.Options(hidden=(150,)))),
    "black box": (position_kernel, BlackBox(2, blackbox.Options(hidden=(150,)))),
}


@pytest.mark.parametrize("name", KERNELS)
def test_each_kind_of_model_has_its_kernel(name, data):
    wanted, model = KERNELS[name]
    problem = _problem(model, [FORWARD if name == "black box" else INVERSE], data, None)
    kernels = {make: make(problem) for make in (network_kernel, position_kernel, generated_kernel)}
    assert kernels[wanted] is not None
    with unoptimised():
        assert native(problem) is not None
    if name != "t2":
        assert kernels[network_kernel] is None


def test_large_models_without_a_kernel_stay_with_torch(data):
    assert native(_problem(Lagrangian(t2, 2, hidden=(150,), momentum_hidden=(2,)), [INVERSE], data, None)) is None
