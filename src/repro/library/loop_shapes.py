"""What a picture shows of a stored closed loop: the shapes of its system, and of its goal."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from repro.control.task import Task
from repro.library.drawn_motion import drawn_shapes
from repro.mechanics.system import System, load_system
from repro.mechanics.system_options import Reading, SystemOptions
from repro.recording.contents import DrawnShape

SETTINGS = ("name", "damping", "damping_frame", "damping_growth", "coulomb")  # of a system, besides its constants


def loop_shapes(
    settings: Mapping[str, Any], series: Mapping[str, np.ndarray], place: float | None
) -> tuple[list[DrawnShape], list[DrawnShape], np.ndarray]:
    """Shapes along a loop, those of its goal (one step), and the inputs (steps, n_u) as parts of their limits.

    series: coordinates and inputs (steps,) by name.
    settings: of the run by dotted key; place: the goal of coordinate x in m, where it has one.
    """
    chosen = {key.removeprefix("system."): value for key, value in settings.items() if key.startswith("system.")}
    constants = {name: float(value) for name, value in chosen.items() if name not in SETTINGS}
    system = load_system(SystemOptions(chosen["name"], Reading(settings["reading.name"]), constants=constants))
    q = np.stack([series[c.name] for c in system.coordinates], axis=-1)
    states = np.concatenate([q, np.zeros_like(q)], axis=-1)
    goal = np.append(_goal(system, settings, place), np.zeros(system.n_q))[None]
    limits = [settings.get("control.force_limit") or each.limit for each in system.inputs]
    inputs = np.stack([series[each.name] for each in system.inputs], axis=-1) / limits
    return drawn_shapes(system, states), drawn_shapes(system, goal), np.nan_to_num(inputs)


def _goal(system: System, settings: Mapping[str, Any], place: float | None) -> np.ndarray:
    prefix = "task.goal."
    further = {key.removeprefix(prefix): float(value) for key, value in settings.items() if key.startswith(prefix)}
    moved = () if place is None else (place,)
    task = Task(name="", end=settings.get("task.end", Task.end), x_des=moved, goal=further)
    return task.goals(system)[0].q
