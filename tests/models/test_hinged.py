"""Composition: a cart with a rod and a free rod, hinged, are the double pendulum."""

import casadi
import numpy as np
import pytest

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.bases import fxf, rigid_body, t1
from repro.models.context import Context, SubModel
from repro.models.damped import Damped
from repro.models.interconnection import Interconnection, Joined
from repro.models.kinds import extended, hinged, port_hamiltonian, structured
from repro.models.kinds.hinged import Hinged, RodOfUnknownMass
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian

# of sip_rod and of the second rod: halves of masses and inertias, first moments, weights
CART = np.array([0.4, 0.2 * 0.25 / 6, 0.05, 0.49])
ROD = np.array([0.1, 0.2 * 0.25 / 24, 1.96])


def _hinged(cart=None, rod=None, up=1.0):
    return Hinged(cart or Lagrangian(t1, 2), rod or Lagrangian(rigid_body, 3), length=0.5, centre=0.25, up=up)


def _samples(count=30):
    generator = np.random.default_rng(2)
    return [scale * generator.normal(size=(count, 3)) for scale in (2.0, 3.0, 4.0)]


def _function(model, *names):
    symbols = {name: casadi.SX.sym(name, model.n_q) for name in ("q", "qd", "qdd", "tau")}
    theta = casadi.SX.sym("theta", model.n_parameters)
    expressions = {
        "qdd": lambda: model.acceleration(symbols["q"], symbols["qd"], symbols["tau"], theta),
        "tau": lambda: model.inverse_dynamics(symbols["q"], symbols["qd"], symbols["qdd"], theta),
        "free": lambda: super(Hinged, model).acceleration(symbols["q"], symbols["qd"], symbols["tau"], theta),
    }
    rows = casadi.vertcat(*(expressions[name]() for name in names))
    return casadi.Function("rows", [*symbols.values(), theta], [casadi.densify(rows)])


@pytest.mark.parametrize("reading", ["physical", "printed"])
def test_true_sub_models_make_the_true_double_pendulum(reading):
    """To rounding, and without a sample of it; the misprinted reading is mirrored from the physical one."""
    physical = reading == "physical"
    model = _hinged(up=1.0 if physical else -1.0)
    weights = np.concatenate([CART * [1, 1, 1, 1.0 if physical else -1.0], ROD])
    q, qd, tau = _samples()
    true = dynamics_of(load("dip"))
    if physical:
        expected = evaluate(true.acceleration, q, qd, tau)
    else:
        turned, mirror = np.array([0, np.pi, np.pi]), np.array([1, -1, -1])
        expected = mirror * evaluate(true.acceleration, turned + mirror * q, mirror * qd, mirror * tau)
    said = evaluate(_function(model, "qdd"), q, qd, 0 * q, tau, weights)
    np.testing.assert_allclose(said, expected, rtol=1e-9, atol=1e-9)


def test_the_multipliers_and_the_reduced_coordinates_give_the_same_motion():
    """With friction in both bodies, and masses that no double pendulum has."""
    model = _hinged(
        Damped(Structured(2, np.array([1.0, 4.0]), structured.Options(hidden=(3,))), "diagonal"),
        Damped(Lagrangian(rigid_body, 3), "diagonal"),
    )
    weights = model.initial([np.random.default_rng(0)])[0]
    weights[model.slices[0]][-2:] = [0.2, 0.05]
    weights[model.slices[1]] = [0.3, 0.02, 1.0, 0.1, 0.2, 0.03]
    q, qd, tau = _samples()
    both = evaluate(_function(model, "qdd", "free"), q, qd, 0 * q, tau, weights)
    np.testing.assert_allclose(both[:, :3], both[:, 3:], rtol=1e-8, atol=1e-8)


def test_the_hinge_does_no_work_and_stays_closed():
    model = _hinged()
    weights = np.concatenate([CART, ROD])
    q, qd, tau = (casadi.SX.sym(name, 3) for name in ("q", "qd", "tau"))
    apart, force = model.constrained(q, qd, tau, casadi.DM(weights))
    place = model.place(q)
    rates = casadi.vertcat(qd[:2], casadi.jtimes(place, q, qd))
    bodies = casadi.vertcat(q[:2], place)
    symbols = casadi.SX.sym("apart", 5)
    joint = casadi.substitute(casadi.jacobian(model.gap(symbols), symbols), symbols, bodies)
    power = casadi.dot(rates, joint.T @ force)
    reduced = casadi.vertcat(
        casadi.jtimes(rates[2:4], q, qd)
        + casadi.jtimes(rates[2:4], qd, model.acceleration(q, qd, tau, casadi.DM(weights)))
    )
    function = casadi.Function("hinge", [q, qd, tau], [casadi.vertcat(power, apart[2:4] - reduced)])
    samples = _samples()
    np.testing.assert_allclose(evaluate(function, samples[0], samples[1], samples[2]), 0, atol=1e-9)


def test_the_energy_and_the_dissipation_are_the_sums_of_the_parts():
    cart = PortHamiltonian(
        Lagrangian(t1, 2), np.ones(2), port_hamiltonian.Options(dissipation="constant", damping_hidden=(8,), floor=0.0)
    )
    model = _hinged(cart, Damped(Lagrangian(rigid_body, 3), "diagonal"))
    generator = np.random.default_rng(0)
    weights = generator.normal(size=model.n_parameters)
    q, qd = casadi.SX.sym("q", 3), casadi.SX.sym("qd", 3)
    place = model.place(q)
    down = [(q[:2], qd[:2]), (place, casadi.jtimes(place, q, qd))]
    whole = model.energies(q, qd, casadi.SX(casadi.DM(weights)))
    gap = casadi.vertcat(
        whole.kinetic, whole.potential, casadi.dot(qd, model.friction(q, qd, casadi.SX(casadi.DM(weights))))
    )
    for part, state, own in zip(model.parts, down, model.slices, strict=True):
        symbols = [casadi.SX.sym(name, part.model.n_q) for name in ("q", "qd")]
        energies = part.model.energies(*symbols, casadi.SX(casadi.DM(weights[own])))
        friction = part.model.friction(*symbols, casadi.SX(casadi.DM(weights[own])))
        rows = casadi.vertcat(energies.kinetic, energies.potential, casadi.dot(symbols[1], friction))
        gap -= casadi.substitute(rows, casadi.vertcat(*symbols), casadi.vertcat(*state))
    function = casadi.Function("gap", [q, qd], [casadi.densify(gap)])
    np.testing.assert_allclose(evaluate(function, *_samples()[:2]), 0, atol=1e-9)


def test_one_unknown_mass_is_all_that_is_missing():
    model = _hinged(rod=RodOfUnknownMass(0.5, 9.8))
    q, qd, qdd = _samples()
    expected = evaluate(dynamics_of(load("dip")).inverse, q, qd, qdd)
    said = evaluate(_function(model, "tau"), q, qd, qdd, 0 * q, np.concatenate([CART, [0.2]]))
    np.testing.assert_allclose(said, expected, rtol=1e-10, atol=1e-10)


def test_parts_start_from_what_they_bring_along():
    given = np.arange(8.0).reshape(2, 4)
    rest = Lagrangian(fxf, 3)
    model = Interconnection([Joined(Lagrangian(t1, 2), lambda q: q[:2]), Joined(rest, lambda q: q)], 3, given)
    start = model.initial([np.random.default_rng(seed) for seed in range(2)])
    np.testing.assert_array_equal(start[:, :4], given)
    assert model.fixed == slice(0, 4)
    assert Interconnection(model.parts, 3, given, frozen=False).fixed == slice(0, 0)
    assert len(model.coefficient_names) == model.n_parameters
    assert model.upstream == slice(0, 4)


def _context(*models):
    zeros = np.ones((1, 4, 3)) * np.arange(4)[:, None]
    parts = tuple(SubModel(model, np.zeros((1, model.n_parameters))) for model in models)
    return Context(fxf, load("dip").coordinates, zeros, zeros, zeros, load("dip"), parts)


def test_what_is_joined_must_fit():
    cart, rod = Lagrangian(t1, 2), Lagrangian(rigid_body, 3)
    assert hinged.build(_context(cart, rod), hinged.Options()).n_parameters == 7
    assert hinged.build(_context(cart), hinged.Options(rod="mass")).n_parameters == 5
    assert hinged.build(_context(cart), hinged.Options(rod="rigid_body")).n_parameters == 7
    for models in ([cart], [rod, cart], [cart, cart]):
        with pytest.raises(UserError, match="parts"):
            hinged.build(_context(*models), hinged.Options())
    built = extended.build(_context(cart), extended.Options(hidden=(3,), rest="basis"))
    assert built.n_parameters == 4 + Lagrangian(fxf, 3).n_parameters
    with pytest.raises(UserError, match="parts"):
        extended.build(_context(rod), extended.Options(hidden=(3,)))


def test_the_rest_starts_as_what_the_part_leaves_of_the_inertia():
    """The data suggest M = diag(velocity_scale^-2); a part that is more than that leaves a tenth of it."""
    cart = SubModel(Lagrangian(t1, 2), CART[None])
    inertia = extended.mean_inertia(cart, np.random.default_rng(0).normal(size=(2, 50, 3)))
    np.testing.assert_allclose(inertia, [0.8, 0.2 * 0.25 / 3], rtol=1e-12)
    scale = extended.remaining_scale(np.array([1.0, 10.0, 5.0]), inertia)
    np.testing.assert_allclose(scale**-2.0, [0.2, 0.001, 0.04], rtol=1e-12)
