"""The race to accuracies: racers whose errors are known at every second, then the real ones on a clock of steps."""

import itertools
from functools import partial

import numpy as np
import pytest
import torch

from repro.bench.accuracy import (
    METRICS,
    OPTIMISERS,
    RESOLUTION,
    Entrant,
    Race,
    Racer,
    racer,
)
from repro.bench.naive import automatic_problem, naive_problem, t2_features
from repro.bench.training_case import PENDULUM, TrainingCase, network, pendulum, triangular
from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.bases import t2

MOTION, ENERGY = METRICS
INVERSE = partial(TrainingCase.problem, equation="inverse")
DATA = partial(pendulum, range(2), 50)

# torch.func loads its rules for forward mode with a function that torch itself deprecates
pytestmark = [
    pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning"),
    pytest.mark.usefixtures("unoptimised"),
]


class Hand:
    """A clock that is turned by hand."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def true(data):
    test = data.test
    return test.qdd, evaluate(dynamics_of(load(PENDULUM)).hamiltonian, test.q, test.qd)[..., 0]


def inverse_of_time(hand: Hand, rate: float = 1.0, look_s: float = 0.0, trained: list[float] | None = None) -> Racer:
    """After k s the error of qdd is just below rate / k of the trivial one's, that of H is its square."""

    def enter(data):
        motion, energy = true(data)

        def train(start, course):
            begun = hand.now
            for k in itertools.count(1):
                hand.now += 1.0
                if trained is not None:
                    trained.append(hand.now - begun)
                course(torch.tensor([[(1 - 1e-9) * rate / k]], dtype=torch.float64))

        def predict(start, weights):
            hand.now += look_s
            (share,) = weights
            return (1 + share) * motion[start], (1 + share**2) * energy[start] + 7.0

        return Entrant(train, predict)

    return Racer(f"rate {rate:g}", enter)


@pytest.mark.parametrize("look_s", [0.0, 1000.0])
def test_times_to_accuracies_are_those_of_the_known_errors(look_s):
    """Whatever a look at the weights takes."""
    hand = Hand()
    race = Race(DATA, [0.2, 0.01], 1e3, hand)
    ours, other = inverse_of_time(hand, look_s=look_s), inverse_of_time(hand, 2.0, look_s)
    for metric, goal, seconds in ((MOTION, 0.2, 5.0), (ENERGY, 0.01, 10.0), (ENERGY, 0.04, 5.0)):
        pairs = race.pairs(ours, other, metric, goal)
        np.testing.assert_allclose(pairs.ours, seconds)
        np.testing.assert_allclose(pairs.ratios, 2.0)
    late = race.pairs(ours, other, MOTION, 0.01)
    assert np.all((late.ours >= 100) & (late.ours <= 101 * RESOLUTION))


def test_what_is_not_reached_in_time_is_never_filled_in():
    hand = Hand()
    race = Race(DATA, [0.1, 0.01], 15.0, hand)
    ours, other = inverse_of_time(hand), inverse_of_time(hand, 2.0)
    assert race.pairs(ours, other, MOTION, 0.1).ratios.tolist() == [np.inf, np.inf]
    assert race.pairs(other, ours, MOTION, 0.1).ratios.tolist() == [0.0, 0.0]
    neither = race.pairs(ours, other, MOTION, 0.01)
    assert np.isinf(neither.ours).all() and np.isinf(neither.other).all() and not len(neither.ratios)
    assert np.isnan(neither.summary()["ratio_median"])


def test_a_training_ends_at_its_last_goal_or_at_the_limit():
    for limit_s, last in ((1e3, 10.0), (6.0, 7.0)):
        hand, trained = Hand(), []
        Race(DATA, [0.5, 0.1], limit_s, hand).courses(inverse_of_time(hand, trained=trained))
        assert max(trained) == last


def test_a_racer_runs_once_from_each_start_however_often_it_is_compared():
    hand, trained = Hand(), []
    race = Race(DATA, [0.5, 0.1], 1e3, hand)
    ours = inverse_of_time(hand, trained=trained)
    for other, metric in itertools.product((inverse_of_time(hand, 2.0), inverse_of_time(hand, 3.0)), METRICS):
        race.pairs(ours, other, metric, 0.5)
    assert trained == [1.0, 2.0, 3.0, *range(1, 11), *range(1, 11)]  # a warm-up, and two starts


def test_errors_are_shares_of_those_of_a_model_without_motion_or_energy():
    race = Race(DATA, [0.1], 1.0)
    (motion, *_), (energy, *_) = true(race.data)
    np.testing.assert_allclose(race.errors(0, motion, energy + 3.0), 0.0, atol=1e-12)
    np.testing.assert_allclose(race.errors(0, 0 * motion, np.zeros_like(energy)), 1.0)
    assert np.isinf(race.errors(0, motion + np.inf, energy)[0])


def test_no_training_has_the_samples_that_it_is_judged_on():
    data = DATA()
    seen = {row.tobytes() for row in data.train.q[0]}
    assert data.n_train == 40 and not seen & {row.tobytes() for row in data.test.q[0][1:]}


small_delan, small_plnn = triangular((4,)), network(t2, (4,))


def ticking():
    return partial(next, itertools.count(0.0))


@pytest.mark.parametrize("equation", ["inverse", "forward"])
@pytest.mark.parametrize("optimiser", OPTIMISERS)
def test_every_optimiser_is_watched_while_it_trains(optimiser, equation):
    """On a clock that ticks once a reading the limit is a number of steps."""
    watched = racer("", small_plnn, partial(TrainingCase.problem, equation=equation), optimiser)
    for course in Race(DATA, [1e-9], 40.0, ticking()).courses(watched):
        assert len(course.seconds) > 5 and max(course.seconds) <= 40.0
        assert not np.array_equal(course.errors[0], course.errors[-1])


def test_levenberg_marquardt_learns_the_energy():
    watched = racer("", small_plnn, INVERSE, "Levenberg-Marquardt")
    (course,) = Race(partial(pendulum, [0], 500), [1e-9], 100.0, ticking()).courses(watched)
    assert course.errors[-1][1] < 0.2 * course.errors[0][1]


@pytest.mark.parametrize(
    ("make", "naive"),
    [(small_delan, automatic_problem), (small_plnn, partial(naive_problem, equation="inverse", features=t2_features))],
)
def test_the_naive_form_learns_by_the_steps_of_the_analytic_one(make, naive):
    ways = (racer("", make, problem_of, "Adam, torch") for problem_of in (INVERSE, naive))
    analytic, automatic = (Race(DATA, [1e-9], 15.0, ticking()).courses(each) for each in ways)
    for one, other in zip(analytic, automatic, strict=True):
        np.testing.assert_allclose(other.errors, one.errors, rtol=1e-4)
        assert not np.allclose(one.errors[0], one.errors[8], rtol=1e-2)
