"""Fitting from Python: arrays in, an ensemble out, and what can be asked of it."""

import numpy as np
import pandas as pd
import pytest
import torch
from torch import nn

import repro
from repro.config.compose import compose
from repro.errors import UserError
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.store import Store


@pytest.fixture(scope="module")
def data():
    return repro.simulate("sip", samples=400, reset="random", seeds=2, episode_steps=40)


@pytest.fixture(scope="module")
def fitted(data):
    return repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares", seeds=2, system=repro.system("sip"))


def test_a_linear_fit_is_exact(fitted, data):
    test = data.test
    tau = fitted.tau(test.q[0], test.qd[0], test.qdd[0])
    assert tau.shape == (2, *test.tau[0].shape)
    np.testing.assert_allclose(tau, np.broadcast_to(test.tau[0], tau.shape), atol=1e-9)
    np.testing.assert_allclose(fitted.acceleration(test.q[0], test.qd[0], test.tau[0])[1], test.qdd[0], atol=1e-8)
    assert fitted.score().loc["mae_tau", [0, 1]].max() < 1e-9


def test_energies_momentum_and_mass_are_those_of_one_lagrangian(fitted):
    q, qd = np.array([[0.0, 0.3], [0.1, 2.0], [0.2, -1.0]]), np.array([[1.0, -1.0], [0.0, 0.5], [2.0, 3.0]])
    energies, momentum, mass = fitted.energies(q, qd), fitted.momentum(q, qd), fitted.mass_matrix(q, qd)
    assert energies.kinetic.shape == (2, 3)
    assert mass.shape == (2, 3, 2, 2)
    np.testing.assert_allclose(np.einsum("mnij,nj->mni", mass, qd), momentum, atol=1e-9)
    np.testing.assert_allclose(energies.kinetic, np.einsum("mni,ni->mn", momentum, qd) / 2, atol=1e-9)
    np.testing.assert_allclose(energies.hamiltonian, energies.kinetic + energies.potential, atol=1e-9)
    np.testing.assert_allclose(fitted.energies(q, 0 * qd).kinetic, 0.0, atol=1e-12)


def test_a_rollout_without_force_conserves_energy(fitted):
    states = fitted.rollout([0.0, 3.0], [0.0, 0.0], np.zeros((50, 2)))
    q, qd = np.split(states[0], 2, axis=-1)
    energy = fitted.energies(q, qd).hamiltonian[0]
    assert states.shape == (2, 51, 4)
    assert np.ptp(energy) < 1e-5
    gradient, drift = fitted.port_form(q[:3], qd[:3])
    np.testing.assert_allclose((gradient * drift).sum(-1), 0.0, atol=1e-12)


def test_arrays_frames_and_the_simulator_give_the_same_fit(data, fitted):
    one = data.q[0], data.qd[0], data.tau[0]
    options = {"coordinates": ["x", "theta"], "angles": ["theta"], "cyclic": ["x"], "time_step": 0.04}
    arrays = repro.dataset(*one, qdd=data.qdd[0], episode=data.episode, **options)
    columns = {role: [f"{role}{i}" for i in range(2)] for role in ("q", "qd", "tau", "qdd")}
    frame = pd.DataFrame(
        {name: getattr(data, role)[0, :, i] for role, names in columns.items() for i, name in enumerate(names)}
    ).assign(run=data.episode)
    framed = repro.dataset_from_frame(frame, **columns, episode="run", **options)
    for own in (arrays, framed):
        again = repro.fit(own, "lagrangian", basis="t1", optimiser="least_squares")
        np.testing.assert_array_equal(again.weights_[0], fitted.weights_[0])


def test_differenced_accelerations_are_for_an_episode_alone():
    t = np.arange(10.0)[:, None]
    data = repro.dataset(t**2, 2 * t, 0 * t, time_step=1.0, episode=[0] * 5 + [1] * 5)
    np.testing.assert_allclose(data.qdd, 2.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": np.zeros((5, 2, 1, 1))}, r"q has shape \(5, 2, 1, 1\)"),
        ({"qd": np.zeros((4, 2))}, r"qd has shape \(1, 4, 2\), q has \(1, 5, 2\)"),
        ({"tau": np.full((5, 2), np.nan)}, "tau has no finite number at sample 0, coordinate 0"),
        ({"angles": ["phi"]}, "'phi' is no coordinate; there are q0, q1"),
        ({"coordinates": ["x"]}, "coordinates names 1, q has 2"),
        ({"episode": [0, 1]}, "episode has shape"),
    ],
)
def test_arrays_that_do_not_fit_are_named(change, message):
    arguments = {"q": np.zeros((5, 2)), "qd": np.zeros((5, 2)), "tau": np.zeros((5, 2)), "time_step": 0.1} | change
    with pytest.raises(UserError, match=message):
        repro.dataset(**arguments)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: repro.model("structurd"), "did you mean structured"),
        (lambda: repro.model("structured", hiden=[3]), "did you mean hidden"),
        (lambda: repro.model("structured", hidden=[-3]), "hidden.0 = -3"),
        (lambda: repro.optimiser("adam", epochs=0), "adam.epochs = 0: should be greater than 0"),
        (lambda: repro.objective("backward"), "backward"),
        (lambda: repro.simulate("sip", samples=5), "samples = 5"),
        (lambda: repro.fit(repro.simulate("sip", samples=50, seeds=2), seeds=3), "2 members and 3 seeds"),
    ],
)
def test_choices_that_do_not_exist_are_named(call, message):
    with pytest.raises(UserError, match=message):
        call()


class Net(nn.Module):
    """L of a cart with one link, as most people would write it."""

    def __init__(self, scale=torch.sin):
        super().__init__()
        self.scale, self.net = scale, nn.Sequential(nn.Linear(4, 8), nn.Softplus(), nn.Linear(8, 1))

    def forward(self, q, qd):
        seen = torch.cat([torch.cos(q[..., 1:]), self.scale(q[..., 1:]), qd], dim=-1)
        return self.net(seen) + (qd**2).sum(-1, keepdim=True)


@pytest.mark.parametrize("objective", ["inverse", "forward"])
@pytest.mark.parametrize("factory", [Net, lambda: Net(torch.erfc)], ids=["symbolic", "opaque"])
def test_anyones_network_is_fitted_both_ways(data, objective, factory):
    few = data.select(slice(0, 100), 80)
    fitted = repro.fit(few, factory, objective=objective, optimiser=repro.optimiser("lbfgs", iterations=5), seeds=2)
    losses = [values for _, name, values in fitted.curves_ if name == "loss"]
    assert (losses[-1] < losses[0]).all()
    states = fitted.rollout([0.0, 3.0], [0.0, 0.0], np.zeros((3, 2)))
    assert np.isfinite(states).all()


def test_both_ways_of_moving_agree(data):
    """The compiled simulator and predictions alone follow the same motion."""
    fitted = repro.fit(data, Net, optimiser=repro.optimiser("lbfgs", iterations=3), seeds=2)
    compiled = fitted.rollout([0.0, 3.0], [0.0, 0.0], np.zeros((3, 2)))
    fitted.model.not_symbolic = "for this test"
    predicted = fitted.rollout([0.0, 3.0], [0.0, 0.0], np.zeros((3, 2)))
    np.testing.assert_allclose(predicted, compiled, atol=1e-5)


def test_what_needs_expressions_is_refused_in_one_line(data, tmp_path):
    opaque = repro.fit(data, lambda: Net(torch.erfc), optimiser=repro.optimiser("lbfgs", iterations=1), seeds=2)
    with pytest.raises(UserError, match="erfc has no symbolic form"):
        opaque.export(tmp_path / "out")
    gradient, drift = opaque.port_form([0, 0.5], [1, 2])  # by torch.func
    np.testing.assert_allclose((gradient * drift).sum(-1), 0.0, atol=1e-12)


def test_a_fit_is_saved_and_loaded(fitted, tmp_path):
    fitted.save(tmp_path / "kept")
    again = fitted.load(tmp_path / "kept")
    np.testing.assert_array_equal(again.weights_, fitted.weights_)
    np.testing.assert_array_equal(again.tau([0, 1], [1, 1], [0, 0]), fitted.tau([0, 1], [1, 1], [0, 0]))
    with pytest.raises(UserError, match="holds no fitted model"):
        fitted.load(tmp_path)


def test_one_member_is_an_ensemble_of_one(fitted):
    alone = fitted.member(1)
    np.testing.assert_array_equal(alone.tau([0, 1], [1, 1], [0, 0])[0], fitted.tau([0, 1], [1, 1], [0, 0])[1])
    assert alone.seeds == (1,)


def test_pictures_and_notebooks(fitted):
    figure = fitted.plot()
    assert [axis.get_xlabel() for axis in figure.axes] == ["time, s"] * 3 + ["step of the optimiser"]
    assert "mae_tau" in fitted._repr_html_()


def test_an_exported_fit_needs_nothing_of_the_project(fitted, tmp_path):
    names = fitted.export(tmp_path / "out")
    assert "README.md" in names


def test_a_fit_from_python_equals_a_run_to_the_bit(tmp_path):
    words = [
        "model=structured", "optimiser=levenberg_marquardt", "optimiser.iterations=4", "optimiser.restarts=1",
        "optimiser.trial_iterations=2", "optimiser.samples=50", "data.samples=100", "data.reset=random", "scale=paper",
        "seeds=2", "data.episode_steps=20",
    ]  # fmt: skip
    run = execute(Pipeline.of(compose(words).config, "test"), Store(tmp_path))
    stored = repro.load_run(run.id, root=tmp_path)
    short = repro.optimiser("levenberg_marquardt", iterations=4, restarts=1, trial_iterations=2, samples=50)
    data = repro.simulate("sip", samples=100, reset="random", episode_steps=20, seeds=2)
    fitted = repro.fit(data, repro.model("structured"), optimiser=short, seeds=2)
    np.testing.assert_array_equal(fitted.weights_, stored.parameters.numpy())


def test_a_fitted_model_erects_its_plant(fitted):
    task = repro.task(initial_states=2, x_des=[0.0], radius=0.0, seconds=6.0)
    fast = repro.controller("mpc", intervals=15, coarse_intervals=15, stage_cost={"potential": 1, "force": 0.01},
                            terminal_cost={"kinetic": 1, "potential": 1, "position": 1})  # fmt: skip
    done = fitted.control(task, fast)
    upright = [np.cos(loop.states[-1, 1]) for loop in done.loops]
    assert len(done.loops) == 2
    assert min(upright) > 0.99
    assert all(np.abs(loop.inputs).max() <= repro.system("sip").inputs[0].limit + 1e-6 for loop in done.loops)


def test_what_cannot_be_controlled_is_refused_in_one_line(data, fitted):
    task = repro.task(initial_states=1)
    opaque = repro.fit(data, lambda: Net(torch.erfc), optimiser=repro.optimiser("lbfgs", iterations=1), seeds=2)
    with pytest.raises(UserError, match="no plant is known"):
        opaque.control(task)
    with pytest.raises(UserError, match="erfc has no symbolic form"):
        opaque.control(task, plant=repro.system("sip"))
    with pytest.raises(UserError, match=r"task\.start = 'flying'"):
        fitted.control(repro.task("flying"))
    with pytest.raises(UserError, match=r"task\.delay = 0\.05: must be shorter than control\.time_step = 0\.04"):
        fitted.control(repro.task(delay=0.05))
    with pytest.raises(UserError, match=r"task\.damping = \[0\.1\]: needs 2 numbers"):
        fitted.control(repro.task(damping=[0.1]))
