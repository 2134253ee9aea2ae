"""What recordings and figures draw of a system, of coordinates alone, and of a stored closed loop."""

from collections.abc import Mapping, Sequence
from typing import Any, assert_never

import numpy as np

from repro.control.task import Task
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.inputs import input_matrix
from repro.mechanics.shapes import Block, Circle, InputArrow, Segment, Shape, Spring, Turn
from repro.mechanics.system import System, load_system
from repro.mechanics.system_options import Reading, SystemOptions
from repro.recording.contents import DrawnShape

SETTINGS = ("damping_growth",)  # numbers of a system that are no constants


def drawn_shapes(system: System, states: np.ndarray) -> list[DrawnShape]:
    """The shapes of a system along its states (steps, 2 n_q)."""
    return [_drawn(shape, len(states)) for shape in _shapes(system, states)]


def drawn_coordinates(coordinates: Sequence[Coordinate], states: np.ndarray) -> list[DrawnShape]:
    """Side by side, a hand of 1 m that turns with each angle (0 is up), and a block at the height of each length."""
    shapes: list[Shape] = []
    for number, coordinate in enumerate(coordinates):
        value, place = states[:, number], 2.5 * number
        if coordinate.is_angle:
            shapes.append(Segment((place, 0.0), (place + np.sin(value), np.cos(value))))
        else:
            shapes.append(Block((place, value), (0.1, 0.1)))
    return [_drawn(shape, len(states)) for shape in shapes]


def tips(system: System, states: np.ndarray) -> np.ndarray:
    """World points (..., 2) in m, y up, of the outermost body: the end of the last link, or the last block or disc."""
    shapes = _shapes(system, states)
    links = [shape.b for shape in shapes if isinstance(shape, Segment) and shape.solid]
    places = links or [shape.centre for shape in shapes if isinstance(shape, Block | Circle)]
    return _points(states.shape[:-1], places[-1])[..., 0, :]


def loop_shapes(
    settings: Mapping[str, object], series: Mapping[str, np.ndarray], place: float | None
) -> tuple[list[DrawnShape], list[DrawnShape], np.ndarray]:
    """Shapes along a loop, those of its goal (one step), and the inputs (steps, n_u) as parts of their limits.

    series: coordinates and inputs (steps,) by name;
    settings: of the run by dotted key; place: the goal of coordinate x in m, where it has one.
    """
    constants = {name: value for name, value in _numbers(settings, "system.").items() if name not in SETTINGS}
    name, reading = str(settings["system.name"]), Reading(str(settings["reading.name"]))
    system = load_system(SystemOptions(name, reading, constants=constants))
    q = np.stack([series[c.name] for c in system.coordinates], axis=-1)
    states = np.concatenate([q, np.zeros_like(q)], axis=-1)
    end, moved = str(settings.get("task.end", Task.end)), () if place is None else (place,)
    reached = Task(name="", end=end, x_des=moved, goal=_numbers(settings, "task.goal.")).goals(system)[0]
    goal = np.append(reached.q, np.zeros(system.n_q))[None]
    limits = [_numbers(settings, "control.").get("force_limit", each.limit) for each in system.inputs]
    inputs = np.stack([series[each.name] for each in system.inputs], axis=-1) / limits
    return drawn_shapes(system, states), drawn_shapes(system, goal), np.nan_to_num(inputs)


def driven_forces(system: System, tau: np.ndarray) -> dict[str, np.ndarray]:
    """The components of tau (steps, n_q) that the inputs of a system reach, by the name of their coordinate."""
    driven = np.any(tau != 0, axis=0) | np.any(input_matrix(system, np.ones(system.n_q)) != 0, axis=1)
    return {c.name: tau[:, index] for index, c in enumerate(system.coordinates) if driven[index]}


def named_inputs(system: System, inputs: np.ndarray) -> dict[str, np.ndarray]:
    """Inputs (steps, n_u) by name."""
    return {each.name: inputs[:, number] for number, each in enumerate(system.inputs)}


def _shapes(system: System, states: np.ndarray) -> list[Shape]:
    return list(system.shapes([states[..., index] for index in range(system.n_q)], np))


def _drawn(shape: Shape, steps: int) -> DrawnShape:
    match shape:
        case Segment():
            return DrawnShape("link", _points((steps,), shape.a, shape.b))
        case Spring():
            return DrawnShape("spring", _points((steps,), shape.a, shape.b), size=(float(shape.coils), 0.0))
        case Circle():
            return DrawnShape("disc", _points((steps,), shape.centre), size=(shape.radius, shape.radius))
        case Block():
            turn = np.broadcast_to(np.asarray(shape.angle, dtype=float), (steps,))
            return DrawnShape("cart" if shape.wheels else "block", _points((steps,), shape.centre), turn, shape.half)
        case InputArrow():
            right, up = _points((steps,), shape.along)[:, 0].T
            return DrawnShape("arrow", _points((steps,), shape.at), np.arctan2(up, right), input=shape.input)
        case Turn():
            size = (shape.radius, 1.0 if shape.clockwise else -1.0)
            return DrawnShape("turn", _points((steps,), shape.at), size=size, input=shape.input)
        case _:
            assert_never(shape)


def _points(leading: tuple[int, ...], *places: Any) -> np.ndarray:
    """World points (..., k, 2) of k places [x, y]."""
    parts = [[np.broadcast_to(np.asarray(part, dtype=float), leading) for part in place] for place in places]
    return np.stack([np.stack(place, axis=-1) for place in parts], axis=-2)


def _numbers(settings: Mapping[str, object], prefix: str) -> dict[str, float]:
    """The numbers among the settings whose keys begin with a prefix, by the rest of the key."""
    return {
        key.removeprefix(prefix): float(value)
        for key, value in settings.items()
        if key.startswith(prefix) and isinstance(value, int | float) and not isinstance(value, bool)
    }
