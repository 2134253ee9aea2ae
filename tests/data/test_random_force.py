import numpy as np
import pytest
from simulated import random_force

from repro.codegen.array_evaluation import evaluate
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load

SYSTEM = load("sip")
SMALL = {"seeds": [0, 1], "samples": 200, "episode_steps": 50}
ARRAYS = ("q", "qd", "qdd", "tau")


def test_samples_obey_the_equations_of_motion() -> None:
    data = random_force(SYSTEM, **SMALL)
    tau = evaluate(dynamics_of(SYSTEM).inverse, data.q, data.qd, data.qdd)
    np.testing.assert_allclose(tau, data.tau, atol=1e-12)


@pytest.mark.parametrize("regime", ["episodes", "long"])
@pytest.mark.parametrize("reading", ["physical", "printed"])
def test_energy_changes_by_the_work_of_the_held_force(regime: str, reading: str) -> None:
    """H[k+1] - H[k] = f[k] (x[k+1] - x[k]) inside every episode: a sample is the start of the step of its force."""
    system = load("sip", reading)
    data = random_force(system, seeds=[3, 4], samples=5000, regime=regime)
    energy = evaluate(dynamics_of(system).hamiltonian, data.q, data.qd)[..., 0]
    error = np.diff(energy, axis=1) - data.tau[:, :-1, 0] * np.diff(data.q[..., 0], axis=1)
    assert np.abs(error[:, np.diff(data.episode) == 0]).max() < 1e-4


def test_fewer_training_samples_are_the_first_ones_and_leave_the_test_part_as_it_is() -> None:
    whole = random_force(SYSTEM, **SMALL, tau_noise=0.1)
    fewer = random_force(SYSTEM, **SMALL, tau_noise=0.1, train_samples=37)
    assert fewer.n_train == fewer.train.samples == 37
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(fewer.train, name), getattr(whole, name)[:, :37])
        np.testing.assert_array_equal(getattr(fewer.test, name), getattr(whole.test, name))
    np.testing.assert_array_equal(fewer.test.time, whole.test.time)
    np.testing.assert_array_equal(fewer.test.episode, whole.test.episode)
    assert random_force(SYSTEM, **SMALL, train_samples=500).n_train == whole.n_train


def test_force_is_uniform_within_its_limit() -> None:
    data = random_force(SYSTEM, seeds=[0], samples=20_000, force_limit=2.0)
    force = data.tau[0, :, 0]
    assert np.all(np.abs(force) <= 2.0)
    assert np.histogram(force, 10, (-2, 2))[0] == pytest.approx(2000, rel=0.1)
    assert np.corrcoef(force[1:], force[:-1])[0, 1] == pytest.approx(0, abs=0.03)
    assert np.all(data.tau[..., 1] == 0)


@pytest.mark.parametrize("start", ["upright", "hanging"])
def test_episodes_start_where_they_should(start: str) -> None:
    data = random_force(SYSTEM, **SMALL, start=start)
    first = np.append(True, np.diff(data.episode) > 0)
    assert first.sum() == 4
    np.testing.assert_array_equal(data.q[:, first], np.broadcast_to(SYSTEM.at_rest(start), (2, 4, 2)))
    np.testing.assert_array_equal(data.qd[:, first], 0)


def test_one_long_trajectory_is_one_episode() -> None:
    data = random_force(SYSTEM, **SMALL, regime="long")
    assert np.all(data.episode == 0)
    assert np.abs(np.diff(data.q, axis=1)).max() < 1


def test_a_last_episode_may_be_shorter() -> None:
    data = random_force(SYSTEM, seeds=[0], samples=130, episode_steps=50)
    np.testing.assert_array_equal(np.bincount(data.episode), [50, 50, 30])
    longer = random_force(SYSTEM, seeds=[0], samples=200, episode_steps=50)
    np.testing.assert_array_equal(data.q, longer.q[:, :130])


def test_random_resets_cover_the_circle() -> None:
    data = random_force(SYSTEM, seeds=[0], samples=4000, episode_steps=2, reset="random")
    first = np.append(True, np.diff(data.episode) > 0)
    q, qd = data.q[0, first], data.qd[0, first]
    assert np.all(q[:, 0] == 0)
    assert np.histogram(q[:, 1], 4, (-np.pi, np.pi))[0] == pytest.approx(500, rel=0.2)
    assert 0.95 < np.abs(qd[:, 0]).max() <= 1
    assert 2.9 < np.abs(qd[:, 1]).max() <= 3


def test_members_depend_on_their_own_seed_alone() -> None:
    together = random_force(SYSTEM, **SMALL, reset="random", qdd_noise=0.1)
    alone = random_force(SYSTEM, **SMALL | {"seeds": [1]}, reset="random", qdd_noise=0.1)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(together, name)[1:], getattr(alone, name))
        if name != "tau":
            assert not np.array_equal(getattr(together, name)[0], getattr(together, name)[1])


def test_streams_are_independent() -> None:
    """Resets and noise leave the force as it was; noise on one quantity leaves the noise on another as it was."""
    plain = random_force(SYSTEM, **SMALL)
    reset = random_force(SYSTEM, **SMALL, reset="random")
    np.testing.assert_array_equal(plain.tau, reset.tau)
    noisy = random_force(SYSTEM, **SMALL, tau_noise=0.1)
    noisier = random_force(SYSTEM, **SMALL, tau_noise=0.1, qd_noise=0.2)
    np.testing.assert_array_equal(noisy.tau, noisier.tau)
    np.testing.assert_array_equal(noisier.q, plain.q)


@pytest.mark.parametrize("name", ARRAYS)
def test_noise_touches_the_named_part_of_training_alone(name: str) -> None:
    arguments = {"seeds": [0], "samples": 4000}
    exact, noisy = random_force(SYSTEM, **arguments), random_force(SYSTEM, **arguments, **{f"{name}_noise": 0.3})
    for other in ARRAYS:
        np.testing.assert_array_equal(getattr(noisy.test, other), getattr(exact.test, other))
        if other != name:
            np.testing.assert_array_equal(getattr(noisy.train, other), getattr(exact.train, other))
    error = getattr(noisy.train, name) - getattr(exact.train, name)
    assert error.std(axis=(0, 1)) == pytest.approx(0.3, rel=0.05)
    assert error.mean() == pytest.approx(0, abs=0.02)


def test_differenced_labels_are_the_mean_acceleration_over_the_step() -> None:
    exact = random_force(SYSTEM, **SMALL)
    differenced = random_force(SYSTEM, **SMALL, labels="differenced")
    inside = np.diff(exact.train.episode) == 0
    forward = np.diff(exact.train.qd, axis=1) / 0.04
    np.testing.assert_allclose(differenced.train.qdd[:, :-1][:, inside], forward[:, inside], rtol=1e-9, atol=1e-9)
    last = np.append(~inside, True)
    np.testing.assert_array_equal(differenced.train.qdd[:, last], differenced.train.qdd[:, np.flatnonzero(last) - 1])
    np.testing.assert_array_equal(differenced.test.qdd, exact.test.qdd)


def test_shared_data_is_that_of_the_first_seed() -> None:
    shared = random_force(SYSTEM, **SMALL | {"seeds": [5, 6, 7]}, common=True, tau_noise=0.1)
    alone = random_force(SYSTEM, **SMALL | {"seeds": [5]}, tau_noise=0.1)
    assert shared.members == 3
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(shared, name), np.repeat(getattr(alone, name), 3, axis=0))


def test_the_same_request_gives_the_same_data() -> None:
    one, other = (random_force(SYSTEM, **SMALL, reset="random", q_noise=0.1) for _ in range(2))
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.provenance == other.provenance
    assert one.provenance["system"]["name"] == "sip"


def test_the_papers_hundred_thousand_points() -> None:
    data = random_force(SYSTEM, seeds=[0])
    assert (data.train.samples, data.test.samples) == (80_000, 20_000)
    assert data.time[25] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("samples", 0),
        ("samples", -5),
        ("samples", 1),
        ("episode_steps", 0),
        ("time_step", 0.0),
        ("time_step", float("nan")),
        ("force_limit", -1.0),
        ("train_fraction", 0.0),
        ("train_fraction", 1.0),
        ("train_fraction", 1.5),
        ("train_samples", 0),
        ("tau_noise", -0.1),
        ("qd_noise", float("inf")),
        ("regime", "short"),
        ("start", "sideways"),
        ("reset", "never"),
        ("labels", "guessed"),
        ("seeds", []),
        ("seeds", [0, 0]),
        ("seeds", [-1]),
    ],
)
def test_what_is_out_of_range_is_named(argument: str, value: object) -> None:
    with pytest.raises(UserError, match=argument):
        random_force(SYSTEM, **SMALL | {argument: value})


def test_differencing_needs_two_samples_an_episode() -> None:
    with pytest.raises(UserError, match="single sample"):
        random_force(SYSTEM, **SMALL | {"episode_steps": 1}, labels="differenced")


def test_every_member_is_finite_data() -> None:
    data: Dataset = random_force(load("sip_rod", "printed"), **SMALL)
    assert all(np.isfinite(getattr(data, name)).all() for name in ARRAYS)
