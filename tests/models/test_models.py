"""Every model's engine against the definitions: derivatives by CasADi and autograd of the same Lagrangian."""

import casadi
import numpy as np
import pytest
import torch

from repro.mechanics.derive import derive, evaluate


def test_engine_agrees_with_the_lagrangian_differentiated_by_casadi(lagrangian_model, samples, start, prepare):
    model = lagrangian_model
    parameters = start(model)
    terms = model.evaluate(parameters, prepare(model, samples), mass=True)
    q, qd, theta = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2), casadi.SX.sym("theta", model.n_parameters)
    energies = model.energies(q, qd, theta)
    dynamics = derive(energies.kinetic, energies.potential, casadi.SX(0), q, qd, theta)
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
    dynamics = derive(energies.kinetic, energies.potential, casadi.SX(0), q, qd, theta)
    terms = model.evaluate(parameters, prepare(model, samples), mass=True)
    if torch.linalg.cond(terms.mass).max() > 1e8:
        pytest.fail("the random model is singular: choose other weights")
    ours = terms.acceleration_error(torch.from_numpy(samples["qdd"]), torch.from_numpy(samples["tau"]))
    theta_samples = np.repeat(parameters.numpy()[:, None], 11, axis=1)
    forward = evaluate(dynamics.acceleration, samples["q"], samples["qd"], samples["tau"], theta_samples)
    np.testing.assert_allclose(ours.numpy(), forward - samples["qdd"], rtol=1e-6, atol=1e-7)


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
    torch.testing.assert_close(values, expected.detach())
    for row in range(values.shape[-1]):
        for sample in (0, 7):
            (gradient,) = torch.autograd.grad(expected[:, sample, row].sum(), parameters, retain_graph=True)
            torch.testing.assert_close(jacobian[:, row, sample], gradient, rtol=1e-8, atol=1e-9)


def test_structured_mass_matrix_is_positive_semidefinite_for_any_weights(samples, start, prepare):
    from repro.models.structured import Structured

    model = Structured(2, np.array([1.0, 5.0]))
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
    torch.testing.assert_close(getattr(together, name)[1:2], getattr(alone, name), rtol=1e-12, atol=1e-12)
