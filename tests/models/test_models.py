"""Every model's engine against the definitions: derivatives by CasADi and autograd of the same Lagrangian."""

import casadi
import numpy as np
import pytest
import torch
from tensors import assert_close

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import derive
from repro.models.kinds import structured


def test_engine_agrees_with_the_lagrangian_differentiated_by_casadi(lagrangian_model, samples, start, prepare):
    model = lagrangian_model
    parameters = start(model)
    terms = model.evaluate(parameters, prepare(model, samples), mass=True)
    q, qd, theta = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2), casadi.SX.sym("theta", model.n_parameters)
    energies = model.energies(q, qd, theta)
    dynamics = derive(energies.kinetic, energies.potential, _rayleigh(model, q, qd, theta), q, qd, theta)
    theta_samples = np.repeat(parameters.numpy()[:, None], 11, axis=1)
    state = (samples["q"], samples["qd"])
    for ours, function, inputs in [
        (terms.tau, dynamics.inverse, (*state, samples["qdd"])),
        (terms.momentum, dynamics.momentum, state),
        (terms.mass, dynamics.mass_matrix, state),
        (terms.kinetic[..., None], dynamics.kinetic, state),
        (terms.potential[..., None], dynamics.potential, state),
        (terms.hamiltonian(torch.from_numpy(samples["qd"]))[..., None], dynamics.hamiltonian, state),
    ]:
        expected = evaluate(function, *inputs, theta_samples)
        np.testing.assert_allclose(ours.numpy(), expected.reshape(ours.shape), rtol=1e-9, atol=1e-9)


def test_acceleration_error_is_the_forward_model_minus_the_measurement(lagrangian_model, samples, start, prepare):
    model = lagrangian_model
    parameters = start(model)
    q, qd = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2)
    theta = casadi.SX.sym("theta", model.n_parameters)
    energies = model.energies(q, qd, theta)
    dynamics = derive(energies.kinetic, energies.potential, _rayleigh(model, q, qd, theta), q, qd, theta)
    terms = model.evaluate(parameters, prepare(model, samples), mass=True)
    if torch.linalg.cond(terms.mass).max() > 1e8:
        pytest.fail("the random model is singular: choose other weights")
    ours = terms.acceleration_error(torch.from_numpy(samples["qdd"]), torch.from_numpy(samples["tau"]))
    theta_samples = np.repeat(parameters.numpy()[:, None], 11, axis=1)
    forward = evaluate(dynamics.acceleration, samples["q"], samples["qd"], samples["tau"], theta_samples)
    np.testing.assert_allclose(ours.numpy(), forward - samples["qdd"], rtol=1e-6, atol=1e-7)


def test_expressions_of_the_dynamics_agree_with_those_derived_from_the_energies(lagrangian_model):
    model = lagrangian_model
    q, qd, qdd, tau = (casadi.SX.sym(name, 2) for name in ("q", "qd", "qdd", "tau"))
    theta = casadi.SX.sym("theta", model.n_parameters)
    energies = model.energies(q, qd, theta)
    derived = derive(energies.kinetic, energies.potential, _rayleigh(model, q, qd, theta), q, qd, theta)
    ours = [model.inverse_dynamics(q, qd, qdd, theta), model.acceleration(q, qd, tau, theta)]
    theirs = [derived.inverse(q, qd, qdd, theta), derived.acceleration(q, qd, tau, theta)]
    both = casadi.Function("both", [q, qd, qdd, tau, theta], [casadi.vertcat(*ours), casadi.vertcat(*theirs)])
    generator = np.random.default_rng(4)
    said, expected = map(np.array, both(*(generator.normal(size=size) for size in (2, 2, 2, 2, model.n_parameters))))
    np.testing.assert_allclose(said, expected, rtol=1e-8, atol=1e-9)


def test_the_port_form_is_hamiltons_equations(lagrangian_model):
    """At p = dL/dqd its drift is (qd, dp/dt) of the motion without a force, and its gradient dH/dx along the flow."""
    model = lagrangian_model
    q, qd = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2)
    theta = casadi.SX.sym("theta", model.n_parameters)
    form, momentum = model.port_form(q, qd, theta), model.momentum(q, qd, theta)
    energies = model.energies(q, qd, theta)
    energy = casadi.dot(momentum, qd) - energies.kinetic + energies.potential
    qdd = model.acceleration(q, qd, casadi.SX.zeros(2), theta)

    def rate(function):
        return casadi.jtimes(function, q, qd) + casadi.jtimes(function, qd, qdd)

    motion = casadi.vertcat(qd, rate(momentum))
    rows = [form.drift - motion, casadi.dot(form.gradient, motion) - rate(energy)]
    generator = np.random.default_rng(4)
    error = casadi.Function("error", [q, qd, theta], [casadi.vertcat(*rows), motion])
    gap, scale = map(np.array, error(*(generator.normal(size=size) for size in (2, 2, model.n_parameters))))
    np.testing.assert_allclose(gap, 0, atol=1e-9 * (1 + np.abs(scale).max() ** 2))


@pytest.mark.parametrize("mass", [False, True])
def test_per_sample_gradients_agree_with_autograd(any_model, samples, mass, start, prepare):
    model = any_model
    prepared = prepare(model, samples)
    parameters = start(model).requires_grad_()
    qdd, tau, qd = (torch.from_numpy(samples[name]) for name in ("qdd", "tau", "qd"))

    def residual(terms):
        rows = [terms.acceleration_error(qdd, tau)] if mass or not model.energetic else [terms.tau - tau]
        if model.energetic:
            rows.append(terms.hamiltonian(qd).unsqueeze(-1))
        if terms.transformed_momentum is not None:
            rows.append(terms.transformed_momentum - terms.momentum)
        return torch.cat(rows, dim=-1)

    values, jacobian = model.rows(parameters.detach(), prepared, residual, mass)
    expected = residual(model.evaluate(parameters, prepared, mass))
    assert_close(values, expected.detach())
    for row in range(values.shape[-1]):
        for sample in (0, 7):
            (gradient,) = torch.autograd.grad(expected[:, sample, row].sum(), parameters, retain_graph=True)
            assert_close(jacobian[:, row, sample], gradient, rtol=1e-8, atol=1e-9)


def test_structured_mass_matrix_is_positive_semidefinite_for_any_weights(samples, start, prepare):
    from repro.models.kinds.structured import Structured

    model = Structured(2, np.array([1.0, 5.0]), structured.Options())
    parameters = start(model) * 30
    mass = model.evaluate(parameters, prepare(model, samples), mass=True).mass
    assert torch.linalg.eigvalsh(mass).min() > -1e-9 * torch.linalg.eigvalsh(mass).max()


def test_members_do_not_influence_each_other(any_model, samples, start, prepare):
    model = any_model
    parameters = start(model)
    prepared = prepare(model, samples)
    together = model.evaluate(parameters, prepared, mass=True)
    alone = model.evaluate(parameters[1:2], {k: v[1:2] for k, v in prepared.items()}, mass=True)
    name = "tau" if model.inverse else "acceleration"
    assert_close(getattr(together, name)[1:2], getattr(alone, name), rtol=1e-12, atol=1e-12)


def _rayleigh(model, q, qd, parameters):
    """Half the lost power: the friction of these models is linear in qd."""
    return 0.5 * casadi.dot(qd, model.friction(q, qd, parameters))
