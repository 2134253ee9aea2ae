"""The task of closed loops: starts, goals, the disc to avoid, and the disturbances (conf/task)."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le

from repro.control.conditions import Conditions, Start
from repro.control.controller import ControllerOptions
from repro.control.geometry import Disc, distances_squared
from repro.control.goal import Goal
from repro.mechanics.chain import Chain
from repro.mechanics.system import System
from repro.plugins.options import Count, Natural, NotNegative, Options, Positive

# m: V-A (one link), V-B (two links)
RADIUS_ONE_LINK, RADIUS_MORE_LINKS = 0.3, 0.1
PLACE = "x"  # the coordinate that x_des is the goal of
UNITS = ("deg", "rad", "m", "rate")
Bounds = Mapping[str, Positive | None]
"""A size for every unit ("deg" and "m", "rate" for velocities in SI units), and for coordinates by name."""


@dataclass(frozen=True, kw_only=True)
class Task(Conditions):
    """A task, with the disturbances of `Conditions`: what each option is stands in conf/task/_base.yaml."""

    name: str
    start: str = "hanging"
    initial_states: Count | None = None
    start_seed: Natural = 0
    spread: Bounds = field(default_factory=lambda: {"rad": 0.6, "m": 0.3, "rate": 0.3})
    end: str = "upright"
    x_des: tuple[float, ...] = (0.8,)
    goal: Mapping[str, float] = field(default_factory=dict)
    tolerance: Bounds = field(default_factory=lambda: {"deg": 5.0, "m": 0.05})
    hold: Positive = 2.0
    limits: Bounds = field(default_factory=lambda: {"m": 10.0, "rate": 40.0})
    seconds: Annotated[float, Ge(2), Le(1000)] = 10.0
    centre: tuple[float, float] = (0.0, 0.6)
    radius: NotNegative | None = None

    def disc(self, system: System) -> Disc | None:
        """The disc to avoid."""
        paper = 0.0
        if isinstance(system, Chain):
            paper = RADIUS_ONE_LINK if len(system.angles) == 1 else RADIUS_MORE_LINKS
        radius = paper if self.radius is None else self.radius
        return Disc(self.centre, radius) if radius else None

    def n_loops(self, n_members: int) -> int:
        """Number of closed loops of an ensemble."""
        return max(1, len(self.x_des)) * n_members if self.initial_states is None else self.initial_states

    def starts(self, system: System, n_members: int) -> list[tuple[Start, int]]:
        """The start of every loop, and the index of the member that drives it."""
        goals = self.goals(system)
        if self.initial_states is None:
            starts = [Start(self.start, self._at_rest(system), goal, (0, 0)) for goal in goals]
            return [(start, member) for start in starts for member in range(n_members)]
        drawn = [self.random_start(system, goals[k % len(goals)], k) for k in range(self.initial_states)]
        return [(start, k % n_members) for k, start in enumerate(drawn)]

    def goals(self, system: System) -> list[Goal]:
        """The goals of loops, in turn."""
        names = [coordinate.name for coordinate in system.coordinates]
        tolerance = self._sizes(system, self.tolerance)
        found = []
        for place in self.x_des or (None,):
            q = system.at_rest(self.end)
            moved = {**self.goal} if place is None else {**self.goal, PLACE: place}
            for name, value in moved.items():
                q[names.index(name)] = value
            found.append(Goal(system.coordinates, q, tolerance, self.hold))
        return found

    def random_start(self, system: System, goal: Goal, number: int) -> Start:
        """One of many starts; it depends on its number, not on how many there are."""
        generator = np.random.default_rng([self.start_seed, number])
        spread = self._both(system, self.spread, 0.0)
        state = self._at_rest(system) + spread * generator.uniform(-1, 1, 2 * system.n_q)
        return Start(f"random {number}", state, goal, (self.start_seed, number))

    def bounds(self, system: System) -> np.ndarray:
        """The absolute values of a state (2 n_q,) up to which a loop goes on."""
        return self._both(system, self.limits, np.inf)

    def problems(self, system: System, controller: ControllerOptions) -> Iterator[str]:
        """What does not fit a system and its controller, one line each."""
        states, coordinates = tuple(system.rest_states), [coordinate.name for coordinate in system.coordinates]
        for key, name in (("start", self.start), ("end", self.end)):
            if name not in states:
                yield f"task.{key} = {name!r}: system={system.name} rests at {', '.join(states)}"
        named = {"goal": self.goal, "spread": self.spread, "tolerance": self.tolerance, "limits": self.limits}
        for key, values in named.items():
            for name in set(values) - {*coordinates, *(() if key == "goal" else UNITS)}:
                yield f"task.{key}.{name}: system={system.name} has coordinates {', '.join(coordinates)}"
        if self.delay >= controller.time_step:
            yield f"task.delay = {self.delay}: must be shorter than control.time_step = {controller.time_step}"
        if len(self.damping) not in (0, system.n_q):
            yield f"task.damping = {list(self.damping)}: needs {system.n_q} numbers, or none"
        disc = self.disc(system)
        at_rest = system.shapes(list(system.at_rest()), np)
        if disc is not None and not distances_squared(at_rest, disc.centre, np):
            yield f"task.radius = {self.radius}: system={system.name} has no solid part to meet an obstacle; use 0"
        if self.x_des and PLACE not in coordinates:
            yield (
                f"task.x_des = {list(self.x_des)}: system={system.name} has no coordinate x, only "
                f"{', '.join(coordinates)}; use task=swing_up, or task.x_des=[]"
            )

    def _at_rest(self, system: System) -> np.ndarray:
        """The state (2 n_q,) of rest where loops start; as printed, every angle of a pendulum on a cart is pi."""
        q = system.at_rest(self.start)
        if isinstance(system, Chain) and self.start == "hanging":
            q[list(system.angles)] = np.pi
        return np.concatenate([q, np.zeros(system.n_q)])

    def _both(self, system: System, given: Bounds, default: float) -> np.ndarray:
        """Sizes of coordinates and rates, (2 n_q,)."""
        rate = given.get("rate")
        rates = np.full(system.n_q, default if rate is None else rate)
        return np.concatenate([self._sizes(system, given, default), rates])

    def _sizes(self, system: System, given: Bounds, default: float = np.inf) -> np.ndarray:
        """Sizes of coordinates (n_q,): by name, else by unit, else the default."""
        sizes = np.full(system.n_q, default)
        for i, coordinate in enumerate(system.coordinates):
            degrees = given.get("deg") if coordinate.unit == "rad" else None
            by_unit = given.get(coordinate.unit) if degrees is None else np.deg2rad(degrees)
            size = given.get(coordinate.name, by_unit)
            sizes[i] = default if size is None else size
        return sizes


@dataclass(frozen=True, kw_only=True)
class LoopPlan(Options):
    """The closed loops to run, at most `loops`; canonical: the gauge of the energies in the controller's cost."""

    controller: ControllerOptions
    task: Task
    loops: int
    canonical: bool
