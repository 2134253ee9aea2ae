"""What a picture shows of a stored closed loop: the shapes of its system, and of its goal."""

from collections.abc import Mapping

import numpy as np

from repro.control.task import Task
from repro.library.drawn_motion import drawn_shapes
from repro.mechanics.system import load_system
from repro.mechanics.system_options import Reading, SystemOptions
from repro.recording.contents import DrawnShape

SETTINGS = ("damping_growth",)  # numbers of a system that are no constants


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


def _numbers(settings: Mapping[str, object], prefix: str) -> dict[str, float]:
    """The numbers among the settings whose keys begin with a prefix, by the rest of the key."""
    return {
        key.removeprefix(prefix): float(value)
        for key, value in settings.items()
        if key.startswith(prefix) and isinstance(value, int | float) and not isinstance(value, bool)
    }
