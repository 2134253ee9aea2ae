"""The engine for a device gives what the host's gives; where it needs one, tensors without numbers stand in."""

from contextlib import nullcontext

import numpy as np
import pytest
import torch
from optional import needs_device, without_device

from repro.errors import UserError
from repro.learning.device import device_adam
from repro.learning.device.cuda import captured, check_device
from repro.learning.device.device_adam import DeviceAdam, DeviceProblem, KeptIndices, device_order
from repro.learning.objective import Objective
from repro.learning.objective_options import OBJECTIVES
from repro.learning.optimisers import adam
from repro.learning.optimisers.adam import Adam
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import Phase, make_task, train
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import t1, t2
from repro.models.damped import Damped
from repro.models.kinds import blackbox, structured
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian
from repro.plugins.plugin import plugin

pytestmark = pytest.mark.usefixtures("unoptimised")

CPU = torch.device("cpu")
MODELS = {
    "basis": lambda: Lagrangian(t1, 2),
    "network": lambda: Lagrangian(t2, 2, hidden=(6,)),
    "momentum transform": lambda: Lagrangian(t2, 2, hidden=(5, 4), momentum_hidden=(3,)),
    "friction": lambda: Damped(Lagrangian(t2, 2, hidden=(6,)), "diagonal"),
    "structured": lambda: Structured(2, np.array([0.7, 3.0]), structured.Options(hidden=(5,))),
    "black box": lambda: BlackBox(2, blackbox.Options(hidden=(6,))),
}
EQUATIONS = [(name, equation) for name in MODELS for equation in ("inverse", "forward")]
EQUATIONS.remove(("black box", "inverse"))
SETTINGS = {"learning_rate": 0.003, "decay": 0.1, "batch_size": 60}


def _on_the_device(**settings):
    return DeviceAdam.of(Adam(**SETTINGS | settings), "cpu")


def _objective(name, equation):
    weight = 0.3 if name == "momentum transform" else 0.0
    return Objective(plugin(OBJECTIVES, equation).Options(momentum_weight=weight))


def _hosts_order(seeds, samples, epoch, device):
    return torch.from_numpy(np.stack([adam.shuffled(seed, samples, epoch) for seed in seeds]))


@pytest.mark.parametrize(("name", "equation"), EQUATIONS)
@pytest.mark.parametrize("engine", ["auto", "torch"])
def test_the_weights_are_those_of_the_host(engine, name, equation, data, make_problem, start, monkeypatch):
    """Compiled, or the ensemble in torch; 135 samples in batches of 60 end with a short one."""
    model = MODELS[name]()
    problem, weights = (
        make_problem(model, data, _objective(name, equation)),
        start(model),
    )
    monkeypatch.setattr(device_adam, "device_order", _hosts_order)
    ours = _on_the_device(epochs=5).fit(problem, weights, silent, NoCheckpoint())
    host = Adam(epochs=5, engine=engine, **SETTINGS).fit(problem, weights, silent, NoCheckpoint())
    assert ours.status == host.status == ["ok"] * 3
    scale = (host.parameters - weights).abs().max().item()
    np.testing.assert_allclose(ours.parameters, host.parameters, rtol=0, atol=1e-9 * max(1.0, scale))
    for (step, label, mine), (host_step, host_label, value) in zip(ours.curves, host.curves, strict=True):
        assert (step, label) == (host_step, host_label)
        np.testing.assert_allclose(mine, value, rtol=1e-6)  # near a singular mass matrix rounding grows


def test_known_energies_and_the_cosine_schedule_too(data, free, start, monkeypatch):
    model = Lagrangian(t2, 2, hidden=(6,))
    tasks = [make_task(model, data.train, Objective(), error_scale=5.0)]
    tasks.append(make_task(model, free.train, Objective(energy_weight=0.5)))
    problem = TrainingProblem(model, tasks, [0, 1, 2], l1=torch.full((model.n_parameters,), 1e-3, dtype=torch.float64))
    monkeypatch.setattr(device_adam, "device_order", _hosts_order)
    settings = {"epochs": 4, "schedule": "cosine"}
    ours = _on_the_device(**settings).fit(problem, start(model), silent, NoCheckpoint())
    host = Adam(**SETTINGS | settings).fit(problem, start(model), silent, NoCheckpoint())
    np.testing.assert_allclose(ours.parameters, host.parameters, rtol=0, atol=1e-9)


def test_a_member_that_diverges_keeps_its_last_finite_weights(spoilt, make_problem, start):
    model = Lagrangian(t2, 2, hidden=(6,))
    weights = start(model)
    fitted = _on_the_device(epochs=2).fit(make_problem(model, spoilt), weights, silent, NoCheckpoint())
    assert fitted.status == ["ok", "diverged at epoch 1", "ok"]
    assert torch.equal(fitted.parameters[1], weights[1]) and not torch.equal(fitted.parameters[0], weights[0])


def test_an_interrupted_fit_ends_where_it_would_have(data, make_problem, start, memory):
    model = Lagrangian(t2, 2, hidden=(6,))
    problem, optimiser, interrupted = make_problem(model, data), _on_the_device(epochs=5), memory(stop_at=3)
    whole = optimiser.fit(problem, start(model), silent, NoCheckpoint())
    with pytest.raises(KeyboardInterrupt):
        optimiser.fit(problem, start(model), silent, interrupted)
    interrupted.stop_at = None
    resumed = optimiser.fit(problem, start(model), silent, interrupted)
    assert torch.equal(resumed.parameters, whole.parameters)


def test_single_precision_and_fewer_epochs_are_kept(data, make_problem, start):
    model = Lagrangian(t2, 2, hidden=(6,))
    fitted = (
        _on_the_device(epochs=4, precision="float32")
        .shortened(0.5)
        .fit(make_problem(model, data), start(model), silent, NoCheckpoint())
    )
    assert fitted.parameters.dtype == torch.float32
    assert fitted.notes == {"epochs": 2, "device": "cpu", "not_captured": None}


def test_an_order_follows_from_seed_and_epoch_alone():
    pair, alone = device_order([4, 9], 50, 2, CPU), device_order([9], 50, 2, CPU)
    assert torch.equal(pair[1], alone[0])
    assert torch.equal(pair.sort(1).values, torch.arange(50).expand(2, 50))
    assert not torch.equal(pair[0], pair[1]) and not torch.equal(alone, device_order([9], 50, 3, CPU))


@pytest.mark.parametrize(("name", "equation"), EQUATIONS)
def test_the_loss_needs_nothing_from_the_host(name, equation, data, make_problem, start):
    """On the device without numbers, which any machine has, a tensor of the host beside the others is an error."""
    model, meta = MODELS[name](), torch.device("meta")
    problem = DeviceProblem.of(
        make_problem(model, data, _objective(name, equation)),
        meta,
        torch.float64,
    )
    weights = start(model).to(meta).requires_grad_()
    loss = problem.loss(weights, torch.zeros(3, 20, dtype=torch.int64, device=meta))
    (gradient,) = torch.autograd.grad(loss.sum(), weights)
    assert (loss.device.type, loss.shape, gradient.shape) == ("meta", (3,), weights.shape)


@pytest.mark.parametrize("factor", ["wide", "triangular"])
def test_a_model_that_asks_the_host_is_found_out(factor, data, make_problem, start):
    """What the refusal of a triangular factor rests on."""
    model = Structured(2, np.array([0.7, 3.0]), structured.Options(hidden=(5,), factor=factor))
    meta = torch.device("meta")
    problem = DeviceProblem.of(make_problem(model, data), meta, torch.float64)
    with nullcontext() if factor == "wide" else pytest.raises(RuntimeError, match="device"):
        problem.loss(start(model).to(meta))


def test_lists_as_indices_are_sent_once():
    kept, values = KeptIndices(), torch.arange(12.0).reshape(3, 4)
    with kept:
        first, again = values[:, [1, 3]], values[:, [1, 3]]
        plain = values[1], values[:, 2], values[[0, 2]]
    assert torch.equal(first, values[:, [1, 3]]) and torch.equal(again, first)
    assert [part.shape for part in plain] == [(4,), (3,), (2, 4)]
    assert len(kept._kept) == 1


@without_device
def test_a_step_that_cannot_be_captured_is_taken_as_it_is():
    done = []
    step, reason = captured(lambda: done.append(1))
    step()
    assert reason and len(done) >= 1


@without_device
def test_a_machine_without_the_device_is_told_in_one_line():
    with pytest.raises(UserError, match=r"device = 'cuda'.*device=cpu") as told:
        check_device("cuda")
    assert "\n" not in str(told.value)
    check_device("cpu")


@needs_device
def test_a_graph_gives_what_the_host_gives(data, make_problem, start, monkeypatch):
    model = Lagrangian(t2, 2, hidden=(6,))
    problem, weights = make_problem(model, data), start(model)
    monkeypatch.setattr(device_adam, "device_order", lambda *given: _hosts_order(*given).to(given[-1]))
    ours = DeviceAdam.of(Adam(epochs=5, **SETTINGS), "cuda").fit(problem, weights, silent, NoCheckpoint())
    host = Adam(epochs=5, **SETTINGS).fit(problem, weights, silent, NoCheckpoint())
    assert ours.notes["not_captured"] is None
    np.testing.assert_allclose(ours.parameters, host.parameters, rtol=0, atol=1e-9)


def test_the_phases_of_a_training_follow_each_other(data, make_problem, start):
    model = Lagrangian(t2, 2, hidden=(4,))
    phases = [Phase("first", make_problem(model, data), epochs=1), Phase("second", make_problem(model, data))]
    fitted = train(phases, _on_the_device(epochs=2), start(model))
    assert [step for step, _, _ in fitted.curves] == [1, 2, 3]
    assert fitted.notes == {"epochs": 2, "device": "cpu", "not_captured": None}
