"""The single pendulum's problem, small enough to solve in a test."""

import numpy as np
import pytest

from repro.control.optimal_control_problem import NodeWeights, Obstacle, OptimalControlProblem
from repro.control.predictive_model import PredictiveModel
from repro.control.transcription import Transcription
from repro.mechanics.system import load
from repro.models.kinds.truth import Truth


@pytest.fixture(scope="session")
def system():
    return load("sip")


@pytest.fixture(scope="session")
def truth(system):
    return Truth(system)


@pytest.fixture(scope="session")
def problem():
    return OptimalControlProblem(
        intervals=(0.04,) * 20,
        stage_cost=NodeWeights(potential=1.0, position=1.0, force=0.01),
        terminal_cost=NodeWeights(kinetic=1.0, potential=1.0),
        obstacle=Obstacle(midpoints=True),
        speed_limit=45.0,
    )


@pytest.fixture(scope="session")
def transcribe(system, truth):
    def make(problem, discretisation="shooting"):
        return Transcription(PredictiveModel(truth, system), problem, discretisation)

    return make


@pytest.fixture
def state():
    return np.array([0.05, np.pi - 0.3, 0.1, 0.0])
