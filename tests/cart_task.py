"""The task of the paper's pendulums on a cart, as tests of closed loops use it."""

from repro.control.conditions import Start
from repro.control.goal import Goal
from repro.control.task import Task
from repro.mechanics.system import System


def erect(system: System, x_des: float) -> Goal:
    """Upright, with the cart at x_des."""
    (goal,) = Task(name="hanging", x_des=(x_des,)).goals(system)
    return goal


def hanging_start(system: System, x_des: float) -> Start:
    """Hanging at rest."""
    ((start, _),) = Task(name="hanging", x_des=(x_des,)).starts(system, 1)
    return start


def random_start(system: System, x_des: float, seed: int, number: int) -> Start:
    """Around hanging."""
    return Task(name="random", start_seed=seed).random_start(system, erect(system, x_des), number)
