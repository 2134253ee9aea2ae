"""What a true system is: its coordinates, energies, friction and inputs, from which everything else is derived."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, ClassVar

import numpy as np

from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate, Input, Maths, Rows, Scalars, jointed
from repro.mechanics.shapes import Point, Segment, Shape
from repro.mechanics.system_options import SYSTEMS, SystemOptions
from repro.plugins.checked import validated
from repro.plugins.plugin import plugin, plugin_names

Range = tuple[float, float]
States = Mapping[str, tuple[float, ...]]

SLIDING = 0.01  # m/s, rad/s or A: well above this rate a dry friction has its full size
TURN: Range = (-math.pi, math.pi)  # rad
OF_LINKS = ("reading", "damping_frame", "damping_growth")  # settings of `LinkAngles` alone
RATES: Mapping[str, Range] = {"rad": (-3.0, 3.0), "m": (-1.0, 1.0)}  # of random starts, rad/s and m/s


@dataclass(frozen=True)
class System(ABC):
    """A mechanism; its constants are further fields of a concrete one.

    Energies take sequences of n_q scalar components and a maths namespace `m` with cos and sin (numpy, torch, casadi).
    damping: one viscous coefficient a coordinate; coulomb: one dry friction a coordinate, in the unit of its force.
    """

    name: ClassVar[str]
    settings: ClassVar[tuple[str, ...]] = ("damping", "coulomb")  # fields that are no constants
    signed: ClassVar[tuple[str, ...]] = ()  # constants that need not be positive
    counts: ClassVar[Mapping[str, int]] = {}  # constants that are whole numbers, from 1 to this one

    damping: tuple[float, ...] = ()
    coulomb: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for constant in self.constants():
            value = getattr(self, constant)
            if most := self.counts.get(constant):
                if value not in range(1, most + 1):
                    raise UserError(f"{constant} = {value:g} of {self.name}: must be one of 1 to {most}")
                object.__setattr__(self, constant, int(value))
            elif value <= 0 and constant not in self.signed:
                raise UserError(f"{constant} = {value} of {self.name}: must be a positive number")
        for name in ("damping", "coulomb"):
            given = getattr(self, name)
            values = tuple(float(coefficient) for coefficient in given) or (0.0,) * self.n_q
            if len(values) != self.n_q:
                raise UserError(
                    f"{name} of {self.name} needs {self.n_q} non-negative numbers "
                    f"({', '.join(c.name for c in self.coordinates)}); got {list(given)}"
                )
            object.__setattr__(self, name, values)

    @classmethod
    def constants(cls) -> tuple[str, ...]:
        """Names of the constants that a concrete system adds."""
        return tuple(field.name for field in fields(cls) if field.name not in cls.settings)

    @property
    @abstractmethod
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The generalised coordinates, in order."""

    @property
    def n_q(self) -> int:
        """Number of generalised coordinates."""
        return len(self.coordinates)

    @property
    def angles(self) -> tuple[int, ...]:
        """Positions of the angles among the coordinates."""
        return tuple(i for i, coordinate in enumerate(self.coordinates) if coordinate.is_angle)

    @property
    def rest_states(self) -> States:
        """Coordinates (n_q,) of named states of rest; the first is where data start and where an energy is known."""
        return {"rest": (0.0,) * self.n_q}

    def at_rest(self, name: str | None = None) -> np.ndarray:
        """Coordinates (n_q,) of a state of rest, the first one by default; UserError names those that there are."""
        states = self.rest_states
        chosen = next(iter(states)) if name is None else name
        _check_choice(f"start of {self.name}", chosen, tuple(states))
        return np.array(states[chosen])

    @property
    def reset_ranges(self) -> tuple[tuple[Range, Range], ...]:
        """Per coordinate the (low, high) of its value and of its rate at the start of a random episode.

        Any angle, at up to 3 rad/s; a translation at 0, or within 0.5 m of it where an energy depends on it, at up to
        1 m/s.
        """
        return tuple(
            (TURN if c.is_angle else (0.0, 0.0) if c.cyclic else (-0.5, 0.5), RATES.get(c.unit, (-1.0, 1.0)))
            for c in self.coordinates
        )

    @property
    @abstractmethod
    def inputs(self) -> tuple[Input, ...]:
        """The inputs u, in order."""

    def input_map(self, q: Scalars, m: Maths) -> Rows:
        """Rows of B(q) (n_q, n_u), numbers or expressions: tau = B(q) u. Here input j acts along coordinate j alone."""
        return [[float(i == j) for j in range(len(self.inputs))] for i in range(self.n_q)]

    @abstractmethod
    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy T in J."""

    def coupling(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Term of L = T + coupling - V in J that is linear in the rates, as of a motor: it stores no energy."""
        return 0.0

    @abstractmethod
    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy V in J."""

    @abstractmethod
    def shapes(self, q: Scalars, m: Maths) -> Sequence[Shape]:
        """What a picture shows, in world coordinates [x, y] in m, y up."""

    def body_points(self, q: Scalars, m: Maths) -> list[Point]:
        """World points [x, y] in m, y up: the start of the first solid segment, and the end of each."""
        solid = [shape for shape in self.shapes(q, m) if isinstance(shape, Segment) and shape.solid]
        return [*(segment.a for segment in solid[:1]), *(segment.b for segment in solid)]

    @property
    def first_part(self) -> "System | None":
        """The true sub-system of the first coordinates that is left without the other bodies, where there is one."""
        return None

    @property
    def jointed(self) -> tuple[int, ...]:
        """Positions of the coordinates whose friction acts on their rate relative to that of the one before."""
        return jointed(self.coordinates)

    @property
    def is_coupled(self) -> bool:
        """Whether L has a term that is linear in the rates."""
        return type(self).coupling is not System.coupling

    @property
    def frictionless(self) -> bool:
        """Whether its energy is kept without input."""
        return not any((*self.damping, *self.coulomb))

    def dissipation(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Rayleigh function in W, whose slopes in qd are the friction: c v^2/2, and f |v| rounded below SLIDING."""
        power = 0.0
        for i, (viscous, dry) in enumerate(zip(self.damping, self.coulomb, strict=True)):
            rate = qd[i] - qd[i - 1] if i in self.jointed else qd[i]
            power = power + 0.5 * viscous * self.growth(i, q, m) * rate**2
            if dry:
                power = power + dry * ((rate**2 + SLIDING**2) ** 0.5 - SLIDING)
        return power

    def growth(self, i: int, q: Scalars, m: Maths) -> Any:
        """Factor of the viscous coefficient of coordinate i at q."""
        return 1.0

    def describe(self) -> dict[str, object]:
        """Return name, friction and constants as plain data."""
        return {"name": self.name} | asdict(self) | {name: list(getattr(self, name)) for name in ("damping", "coulomb")}


def load(name: str, reading: str = "physical", damping: Sequence[float] = (), **given: Any) -> System:
    """The system of that name; given: further options and constants by name. UserError for what is not allowed."""
    options = {key: given.pop(key) for key in [*given] if key in SystemOptions.__dataclass_fields__}
    options |= {"name": name, "reading": reading, "damping": tuple(damping), "constants": given}
    return load_system(validated(SystemOptions, name, options))


def load_system(options: SystemOptions) -> System:
    """The true system that options describe; UserError for what is not allowed."""
    _check_choice("system", options.name, plugin_names(SYSTEMS))
    module = plugin(SYSTEMS, options.name)
    (found,) = (
        member
        for member in vars(module).values()
        if isinstance(member, type) and issubclass(member, System) and member.__module__ == module.__name__
    )
    for constant in options.constants:
        _check_choice(f"constant of {options.name}", constant, found.constants())
    given: dict[str, Any] = {"damping": options.damping, "coulomb": options.coulomb, **options.constants}
    for setting in OF_LINKS:
        value, usual = getattr(options, setting), getattr(SystemOptions, setting)
        if setting in found.settings:
            given[setting] = value
        elif value != usual:
            goes = f"system={options.name} goes with {setting} = {usual}"
            raise UserError(f"{setting} = {value}: is for the links of the paper; {goes}")
    return found(**given)


def _check_choice(what: str, value: str, allowed: Sequence[str]) -> None:
    if value not in allowed:
        raise UserError(f"unknown {what} {value!r}: choose one of {', '.join(allowed)}")
