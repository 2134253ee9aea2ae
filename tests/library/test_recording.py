"""Recordings of fits: of a known system, and of arrays alone."""

import numpy as np
import pytest
import torch
from torch import nn

import repro
from repro.errors import UserError
from repro.recording.writer import read_recording


class OneNetwork(nn.Module):
    """L of a cart and one link."""

    def __init__(self):
        super().__init__()
        self.net = nn.Linear(4, 1)

    def forward(self, q, qd):
        features = torch.cat([torch.cos(q[..., 1:]), torch.sin(q[..., 1:]), qd], dim=-1)
        return self.net(features**2)


SHORT = repro.optimiser("levenberg_marquardt", iterations=3, restarts=1)


@pytest.fixture(scope="module")
def data():
    return repro.simulate("sip", samples=200, reset="random", episode_steps=20, seeds=2)


def test_a_fit_is_recorded_beside_its_plant(data, tmp_path):
    fitted = repro.fit(data, "structured", optimiser=SHORT, seeds=2, system=repro.system("sip"))
    tracks = read_recording(fitted.record(tmp_path / "fit.rrd"))
    assert set(tracks["state/theta"].names) == {"θ plant [rad]", "θ seed 0 [rad]"}
    assert len(tracks["energy/H"].at) == data.test.samples
    assert {"learning/log10_loss"} <= set(tracks)
    np.testing.assert_array_equal(tracks["state/theta"].values[:, 0], data.test.q[0, :, 1])


def test_a_recording_has_the_name_of_the_users_own_network(data, tmp_path, monkeypatch):
    written = []
    monkeypatch.setattr("repro.library.run_recording.write_recording", lambda path, content: written.append(content))
    fitted = repro.fit(data, OneNetwork, optimiser=SHORT, seeds=2, system=repro.system("sip"))
    fitted.record(tmp_path / "fit.rrd")
    assert written[0].title == "OneNetwork of sip" and written[0].card["model"] == "OneNetwork"


def test_arrays_without_a_known_system_have_the_energies_of_the_model(data, tmp_path):
    own = repro.dataset(
        data.q[0], data.qd[0], data.tau[0], qdd=data.qdd[0], episode=data.episode, time_step=0.04,
        coordinates=["x", "theta"], angles=["theta"], cyclic=["x"],
    )  # fmt: skip
    fitted = repro.fit(own, "structured", optimiser=SHORT)
    tracks = read_recording(fitted.record(tmp_path / "own.rrd"))
    assert not any(name.startswith("energy/") for name in tracks)
    start = np.split(np.concatenate([own.test.q[0, :1], own.test.qd[0, :1]], axis=1), 2, axis=1)
    first = tracks["further/H_of_seed_0"].values[0, 0]
    assert first == pytest.approx(fitted.energies(*start).hamiltonian[0, 0], rel=1e-9)
    supplied = tracks["power"].values[0, 0]
    assert supplied == pytest.approx((own.test.tau[0, 0] * own.test.qd[0, 0]).sum(), rel=1e-9)


def test_a_model_without_weights_has_nothing_to_record(data, tmp_path):
    with pytest.raises(UserError, match="has no weights"):
        repro.fit(data, "trivial", seeds=2).record(tmp_path / "none.rrd")


def test_a_recording_is_shown_in_a_notebook_where_its_widget_is_installed(data, tmp_path):
    with pytest.raises(UserError, match=r"show: no file .*missing\.rrd"):
        repro.show(tmp_path / "missing.rrd")
    path = repro.fit(data, "structured", optimiser=SHORT, seeds=2).record(tmp_path / "fit.rrd")
    try:
        import rerun_notebook  # noqa: F401
    except ModuleNotFoundError:
        with pytest.raises(UserError, match="repro view"):
            repro.show(path)
    else:
        assert repro.show(path) is not None
