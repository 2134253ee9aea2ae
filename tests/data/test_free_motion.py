import numpy as np
import pytest
from simulated import free_motion

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.mechanics.chain import LinkAngles
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.mechanics.system_options import SYSTEMS
from repro.plugins.plugin import plugin_names

SWINGING = [load(name) for name in plugin_names(SYSTEMS) if name != "link"]  # it is released from its rest length alone
SWINGING += [load(name, "printed") for name in plugin_names(SYSTEMS) if isinstance(load(name), LinkAngles)]

every_system = pytest.mark.parametrize(
    "system", SWINGING, ids=lambda system: f"{system.name}-{getattr(system, 'reading', '')}"
)


@every_system
def test_energy_is_conserved_and_known(system) -> None:
    data = free_motion(system, seeds=[0], initial_angles=8)
    energy = evaluate(dynamics_of(system).hamiltonian, data.q, data.qd)[..., 0]
    np.testing.assert_allclose(energy, data.energy, atol=1e-7)


@every_system
def test_trajectories_start_at_rest_with_their_potential_energy(system) -> None:
    data = free_motion(system, seeds=[0], initial_angles=8)
    first = np.append(True, np.diff(data.episode) > 0)
    assert np.all(data.qd[:, first] == 0)
    assert not any(np.any(data.q[:, first, i]) for i, c in enumerate(system.coordinates) if c.cyclic)
    np.testing.assert_allclose(data.energy[0, first], [system.potential(q, np) for q in data.q[0, first]], atol=1e-15)
    assert np.all(data.tau == 0)
    tau = evaluate(dynamics_of(system).inverse, data.q, data.qd, data.qdd)
    np.testing.assert_allclose(tau, 0, atol=1e-12)


def test_starts_are_a_uniform_grid() -> None:
    data = free_motion(load("sip"), seeds=[4], initial_angles=50, steps=3)
    assert data.samples == 150
    np.testing.assert_allclose(np.sort(data.q[0, ::3, 1]), np.linspace(0.03, 3.11, 50))


def test_every_angle_has_its_own_starts() -> None:
    data = free_motion(load("dip"), seeds=[0], initial_angles=4, steps=1)
    assert len(np.unique(data.q[0], axis=0)) == 16


def test_whole_trajectories_are_split_by_seed() -> None:
    data = free_motion(load("sip"), seeds=[0, 1], initial_angles=20, steps=5)
    assert data.n_train == 80
    assert set(data.train.episode).isdisjoint(data.test.episode)
    held_out = [set(data.test.q[member, ::5, 1]) for member in range(2)]
    assert len(held_out[0]) == len(held_out[1]) == 4
    assert held_out[0] != held_out[1]
    np.testing.assert_array_equal(np.sort(data.q[0], axis=0), np.sort(data.q[1], axis=0))


def test_damped_systems_are_refused() -> None:
    with pytest.raises(UserError, match="damping"):
        free_motion(load("sip", damping=[0.1, 0.0]), seeds=[0])


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("initial_angles", 0),
        ("steps", -1),
        ("time_step", 0.0),
        ("seeds", []),
        ("train_fraction", 0.0),
        ("initial_angles", 1),
    ],
)
def test_what_is_out_of_range_is_named(argument: str, value: object) -> None:
    with pytest.raises(UserError, match=argument):
        free_motion(load("sip"), **{"seeds": [0]} | {argument: value})
