"""What every mechanical system says about itself, and how one is found by name."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, ClassVar

import numpy as np

from repro.errors import UserError
from repro.mechanics.inputs import Input
from repro.mechanics.system_options import SystemOptions
from repro.plugins.plugin import plugin, plugin_names

READINGS = ("physical", "printed")
DAMPING_FRAMES = ("relative", "absolute")


@dataclass(frozen=True)
class Coordinate:
    """One generalised coordinate: its name, its unit, whether it is an angle, and whether it is cyclic.

    Neither T nor V depends on a cyclic coordinate.
    """

    name: str
    unit: str
    is_angle: bool
    cyclic: bool = False


@dataclass(frozen=True)
class System(ABC):
    """A cart that carries a chain of links; the constants of a concrete system are further fields.

    Energies take sequences of n_q scalar components and a maths namespace `m` with cos and sin (numpy, torch, casadi).
    The reading fixes where an absolute link angle is zero: `physical` upright, `printed` hanging (as in eq. 13).
    Damping is one viscous coefficient a joint, cart first: N s/m, then N m s/rad. That of a link at angle th is
    (1 + damping_growth sin(th)^2) times as large.
    """

    name: ClassVar[str]

    reading: str = "physical"
    damping: tuple[float, ...] = ()
    damping_frame: str = "relative"
    damping_growth: float = 0.0

    def __post_init__(self) -> None:
        _check_choice("reading", self.reading, READINGS)
        _check_choice("damping_frame", self.damping_frame, DAMPING_FRAMES)
        damping = tuple(float(coefficient) for coefficient in self.damping) or (0.0,) * self.n_q
        if len(damping) != self.n_q or not all(math.isfinite(c) and c >= 0 for c in damping):
            raise UserError(
                f"damping of {self.name} needs {self.n_q} non-negative numbers "
                f"({', '.join(c.name for c in self.coordinates)}); got {list(self.damping)}"
            )
        if not math.isfinite(self.damping_growth) or self.damping_growth < 0:
            raise UserError(f"damping_growth = {self.damping_growth} of {self.name}: must not be negative")
        object.__setattr__(self, "damping", damping)
        for constant in self.constants():
            value = getattr(self, constant)
            if not math.isfinite(value) or value <= 0:
                raise UserError(f"{constant} = {value} of {self.name}: must be a positive number")

    @classmethod
    def constants(cls) -> tuple[str, ...]:
        """Names of the constants that a concrete system adds."""
        return tuple(field.name for field in fields(cls) if field.name not in System.__dataclass_fields__)

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
    def up(self) -> float:
        """Cosine of the upright angle: 1 where angles are measured from upright, -1 where from hanging."""
        return 1.0 if self.reading == "physical" else -1.0

    @property
    def upright(self) -> np.ndarray:
        """Coordinates (n_q,) with every link pointing up and the cart at 0."""
        return self._links_at(0.0 if self.reading == "physical" else math.pi)

    @property
    def hanging(self) -> np.ndarray:
        """Coordinates (n_q,) with every link pointing down and the cart at 0."""
        return self._links_at(math.pi if self.reading == "physical" else 0.0)

    @property
    @abstractmethod
    def inputs(self) -> tuple[Input, ...]:
        """The inputs u, in order."""

    @abstractmethod
    def input_map(self, q: Sequence[Any], m: Any) -> Sequence[Sequence[Any]]:
        """Rows of B(q), (n_q, n_u): the generalised force is tau = B(q) u. Entries are numbers or expressions in q."""

    @abstractmethod
    def kinetic(self, q: Sequence[Any], qd: Sequence[Any], m: Any) -> Any:
        """Kinetic energy T in J."""

    @abstractmethod
    def potential(self, q: Sequence[Any], m: Any) -> Any:
        """Potential energy V in J, zero where every link is level."""

    @abstractmethod
    def body_points(self, q: Sequence[Any], m: Any) -> list[list[Any]]:
        """World points [x, y] in m, y up: the cart, then the end of every link."""

    def dissipation(self, q: Sequence[Any], qd: Sequence[Any], m: Any) -> Any:
        """Rayleigh function in W: half the power lost in the joints, on relative or absolute rates."""
        power = 0.0
        for i, coefficient in enumerate(self.damping):
            jointed = self.damping_frame == "relative" and i and {i - 1, i} <= {*self.angles}
            rate = qd[i] - qd[i - 1] if jointed else qd[i]
            growth = 1 + self.damping_growth * m.sin(q[i]) ** 2 if self.damping_growth and i in self.angles else 1.0
            power = power + 0.5 * coefficient * growth * rate**2
        return power

    def describe(self) -> dict[str, object]:
        """Return name, reading, damping and constants as plain data."""
        return {"name": self.name} | asdict(self) | {"damping": list(self.damping)}

    def _links_at(self, angle: float) -> np.ndarray:
        return np.array([angle if coordinate.is_angle else 0.0 for coordinate in self.coordinates])


def names() -> tuple[str, ...]:
    """Names of all systems: one per file of mechanics/systems."""
    return plugin_names("mechanics.systems")


def load(
    name: str,
    reading: str = "physical",
    damping: Sequence[float] | None = None,
    damping_frame: str = "relative",
    damping_growth: float = 0.0,
    **constants: float,
) -> System:
    """Return the system of that name, its constants changed where given; UserError for what is not allowed."""
    _check_choice("system", name, names())
    module = plugin("mechanics.systems", name)
    (found,) = (
        member
        for member in vars(module).values()
        if isinstance(member, type) and issubclass(member, System) and member.__module__ == module.__name__
    )
    for constant in constants:
        _check_choice(f"constant of {name}", constant, found.constants())
    joints = tuple(damping or ())
    return found(
        reading=reading, damping=joints, damping_frame=damping_frame, damping_growth=damping_growth, **constants
    )


def load_system(options: SystemOptions) -> System:
    """The true system that options describe; UserError for what is not allowed."""
    return load(
        options.name,
        options.reading,
        options.damping,
        options.damping_frame,
        options.damping_growth,
        **options.constants,
    )


def _check_choice(what: str, value: str, allowed: Sequence[str]) -> None:
    if value not in allowed:
        raise UserError(f"unknown {what} {value!r}: choose one of {', '.join(allowed)}")
