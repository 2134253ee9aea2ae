"""What holds of every system: balance of energy, momenta, derivatives in every algebra, states of rest, its picture."""

import casadi as ca
import numpy as np
import pytest
import torch

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import input_limits, input_matrix, under_inputs
from repro.mechanics.shapes import Circle, InputArrow, Segment, Spring, Turn
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System, load
from repro.mechanics.system_options import SYSTEMS
from repro.plugins.plugin import plugin_names

pytestmark = pytest.mark.usefixtures("unoptimised")

COUNT = 20
SYSTEMS = [load(name) for name in plugin_names(SYSTEMS)]
every_system = pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: system.name)


def random_states(system: System, count: int = COUNT) -> tuple[np.ndarray, np.ndarray]:
    """q and qd (count, n_q) within the reset ranges."""
    low, high = np.array(system.reset_ranges).transpose(2, 1, 0)
    draw = np.random.default_rng(3).uniform(size=(2, count, system.n_q))
    q, qd = low[:, None] + (high - low)[:, None] * draw
    return q, qd


def with_friction(system: System) -> System:
    some = [0.05 + 0.01 * i for i in range(system.n_q)]
    return load(system.name, damping=some, coulomb=some[::-1])


@every_system
def test_energy_changes_by_the_work_of_the_inputs_less_what_friction_takes(system):
    """dH/dt = u'B(q)'qd - qd'dR/dqd, integrated over a simulated motion."""
    rough, step = with_friction(system), 1e-3
    u = np.random.default_rng(1).uniform(-1, 1, len(system.inputs)) * input_limits(system)
    q, qd = random_states(system, 2)
    acceleration = under_inputs(dynamics_of(rough).acceleration, rough)
    states = simulate(acceleration, np.c_[q, qd], np.tile(u, (2, 200, 1)), step)
    q, qd = np.split(states, 2, axis=-1)
    energy = evaluate(dynamics_of(rough).hamiltonian, q, qd)[..., 0]
    supplied = np.einsum("btij,j,bti->bt", input_matrix(system, q), u, qd)
    power = supplied - evaluate(dynamics_of(rough).dissipated_power, q, qd)[..., 0]
    work = np.cumsum((power[:, 1:] + power[:, :-1]) / 2, axis=1) * step
    np.testing.assert_allclose(energy[:, 1:] - energy[:, :1], work, atol=2e-4 * max(1.0, np.abs(work).max()))


@every_system
def test_without_input_and_friction_energy_and_cyclic_momenta_are_kept(system):
    q, qd = random_states(system, 3)
    still = np.zeros((3, 25, system.n_q))
    states = simulate(dynamics_of(system).acceleration, np.c_[q, qd], still, 0.02)
    q, qd = np.split(states, 2, axis=-1)
    energy = evaluate(dynamics_of(system).hamiltonian, q, qd)[..., 0]
    np.testing.assert_allclose(energy, np.broadcast_to(energy[:, :1], energy.shape), rtol=0, atol=1e-5)
    momentum = evaluate(dynamics_of(system).momentum, q, qd)
    for i, coordinate in enumerate(system.coordinates):
        if coordinate.cyclic and type(system).coupling is System.coupling:
            np.testing.assert_allclose(momentum[..., i], np.broadcast_to(momentum[:, :1, i], q.shape[:2]), atol=1e-7)


@every_system
def test_torch_and_casadi_differentiate_alike(system):
    """Momentum and force from T and V by reverse differentiation in torch, against the derived functions."""
    rough, (q, qd) = with_friction(system), random_states(system)
    at, speed = (torch.tensor(values, requires_grad=True) for values in (q, qd))
    parts = at.unbind(-1), speed.unbind(-1)
    kinetic, potential = rough.kinetic(*parts, torch), rough.potential(parts[0], torch)
    lagrangian = kinetic + rough.coupling(*parts, torch) - potential
    (momentum,) = torch.autograd.grad(lagrangian.sum(), speed, retain_graph=True)
    (friction,) = torch.autograd.grad(rough.dissipation(*parts, torch).sum(), speed, retain_graph=True)
    (push,) = torch.autograd.grad(-potential.sum(), at, allow_unused=True, materialize_grads=True)
    dynamics, rest = dynamics_of(rough), np.zeros_like(q)
    np.testing.assert_allclose(momentum.numpy(), evaluate(dynamics.momentum, q, qd), atol=1e-12)
    lost = evaluate(dynamics.dissipated_power, q, qd)[:, 0]
    np.testing.assert_allclose((friction.numpy() * qd).sum(-1), lost, atol=1e-12)
    np.testing.assert_allclose(-push.numpy(), evaluate(dynamics.inverse, q, rest, rest), atol=1e-10)


@every_system
def test_compiled_and_interpreted_simulation_agree(system):
    q, qd = random_states(system, 2)
    tau = np.random.default_rng(5).uniform(-0.2, 0.2, (2, 5, system.n_q))
    one, other = (
        simulate(dynamics_of(system).acceleration, np.c_[q, qd], tau, 0.02, engine=engine) for engine in ("c", "casadi")
    )
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)


@every_system
def test_dry_friction_opposes_motion_with_its_own_size(system):
    dry = load(system.name, damping=[0.0] * system.n_q, coulomb=[0.3] * system.n_q)
    for i in range(system.n_q):
        if i + 1 in dry.jointed:
            continue  # its motion moves the next joint too
        qd = ca.SX.sym("qd", system.n_q)
        q = [0.1] * system.n_q
        friction = ca.Function("friction", [qd], [ca.gradient(dry.dissipation(q, ca.vertsplit(qd), ca), qd)])
        rates = np.zeros(system.n_q)
        for rate in (-2.0, 2.0):
            rates[i] = rate
            assert float(friction(rates)[i]) == pytest.approx(0.3 * np.sign(rate), rel=1e-4)


@every_system
def test_states_of_rest_are_equilibria_under_constant_inputs(system):
    for name in system.rest_states:
        q, still = system.at_rest(name), np.zeros(system.n_q)
        weight = evaluate(dynamics_of(system).inverse, q, still, still)
        matrix = input_matrix(system, q)
        held = np.linalg.lstsq(matrix, weight, rcond=None)[0]
        np.testing.assert_allclose(matrix @ held, weight, atol=1e-12)
        assert np.all(np.abs(held) <= input_limits(system))


@every_system
def test_neither_energy_depends_on_a_cyclic_coordinate(system):
    q, qd = random_states(system)
    moved = q + [1.3 * coordinate.cyclic for coordinate in system.coordinates]
    for energy in ("kinetic", "potential"):
        one, other = (evaluate(getattr(dynamics_of(system), energy), at, qd) for at in (q, moved))
        np.testing.assert_allclose(one, other, atol=1e-12)
    turned = q + [2 * np.pi * coordinate.is_angle for coordinate in system.coordinates]
    one, other = (evaluate(dynamics_of(system).mass_matrix, at, qd) for at in (q, turned))
    np.testing.assert_allclose(one, other, atol=1e-12)


@every_system
def test_every_input_is_drawn_and_every_shape_has_a_place(system):
    q, _ = random_states(system)
    shapes = system.shapes(list(q.T), np)
    arrows = [shape for shape in shapes if isinstance(shape, InputArrow | Turn)]
    if system.name != "rod":  # the part of a composition
        assert sorted(arrow.input for arrow in arrows) == list(range(len(system.inputs)))
    for shape in shapes:
        points = [shape.a, shape.b] if isinstance(shape, Segment | Spring) else []
        points += [shape.centre] if isinstance(shape, Circle) else []
        for point in points:
            assert np.isfinite(np.broadcast_arrays(*point)).all()


@every_system
def test_rigid_links_keep_their_lengths_in_the_plane(system):
    if system.name == "furuta":
        pytest.skip("is seen at an angle")
    q, _ = random_states(system)
    for shape in system.shapes(list(q.T), np):
        if isinstance(shape, Segment):
            a, b = (np.stack(np.broadcast_arrays(*point, q[:, 0])[:2]) for point in (shape.a, shape.b))
            length = np.linalg.norm(b - a, axis=0)
            np.testing.assert_allclose(length, length[0])
