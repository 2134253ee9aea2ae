"""Tiny data and recipes."""

from dataclasses import fields, replace

import numpy as np
import pytest
from simulated import free_motion, random_force

from repro.learning.objective_options import EnergyForm
from repro.learning.objectives import inverse
from repro.learning.sequence_options import SEQUENCES
from repro.library.ensemble_model import Ensemble
from repro.mechanics.system import load
from repro.models.bases import t1
from repro.models.lagrangian import Lagrangian
from repro.plugins.plugin import plugin


@pytest.fixture(scope="session")
def system():
    return load("sip")


@pytest.fixture(scope="session")
def data(system):
    return random_force(system, seeds=[3, 8], samples=600, episode_steps=100)


@pytest.fixture(scope="session")
def free(system):
    return free_motion(system, seeds=[3, 8], initial_angles=12, steps=10)


@pytest.fixture
def recipe():
    """recipe(kind of sequence, changed options of the objective or the sequence)."""

    def make(kind="main", **changes):
        known = {field.name for field in fields(inverse.Options)}
        objective = {name: value for name, value in changes.items() if name in known}
        sequence = {name: value for name, value in changes.items() if name not in known}
        if "energy_form" in sequence:
            sequence["energy_form"] = EnergyForm(sequence["energy_form"])
        return inverse.Options(**objective), plugin(SEQUENCES, kind).Options(**sequence)

    return make


@pytest.fixture
def exact(data, system):
    weights = np.array([[0.4, 0.025, 0.1, 0.98]] * 2)
    model, status = Lagrangian(t1, 2), ("ok", "ok")
    return Ensemble(model, weights, (3, 8), data, status, 1.5, system=system, notes_={"epochs": 7})


@pytest.fixture
def shortened():
    def cut(dataset, samples, n_train):
        arrays = {name: getattr(dataset, name)[:, :samples] for name in ("q", "qd", "qdd", "tau")}
        shared = {name: getattr(dataset, name)[:samples] for name in ("time", "episode")}
        return replace(dataset, **arrays, **shared, n_train=n_train)

    return cut
