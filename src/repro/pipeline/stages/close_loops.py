"""Close the loop: drive the true plant from many starts, and write what came of it as tables."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.control.build import Setting
from repro.control.closed_loop import ClosedLoop, run_loop
from repro.control.conditions import Conditions, Start, hanging_start, random_starts, wrong_weights
from repro.control.loop_tables import keep, row, trajectory
from repro.control.optimal_control_problem import Obstacle
from repro.control.predictive_model import PredictiveModel
from repro.data.dataset import Dataset
from repro.mechanics.system import System
from repro.models.model import Model

LOOPS, TRAJECTORIES, FIRST = "control.parquet", "closed_loops.parquet", "first_loop.npz"
SHOWN = 2  # loops whose trajectories are kept
PRIOR_SAMPLES = 2000
RADII = {1: 0.3}  # m, by number of links, V-A and V-B
RADIUS = 0.1


@dataclass(frozen=True)
class Plan:
    """Which loops to close: conf/control and conf/task as plain options, at most so many loops."""

    control: Mapping[str, Any]
    task: Mapping[str, Any]
    loops: int
    canonical: bool

    def obstacle(self, system: System) -> Obstacle | None:
        """The disc, None for a radius of 0."""
        radius = self.task["radius"]
        if radius is None:
            radius = RADII.get(len(system.angles), RADIUS)
        own = {
            "clearance_radii": "clearance_radii",
            "constraint": "obstacle_constraint",
            "weight": "obstacle_weight",
            "midpoints": "midpoints",
        }
        chosen = {key: self.control[name] for key, name in own.items() if name in self.control}
        return Obstacle(tuple(self.task["centre"]), radius, **chosen) if radius else None

    def starts(self, system: System, members: int) -> list[tuple[Start, int]]:
        """Starts and the number of the member that drives each."""
        x_des = self.task["x_des"]
        if self.task["start"] == "hanging":
            pairs = [(hanging_start(system, x), member) for x in x_des for member in range(members)]
            return pairs[: self.loops]
        count = min(self.task["initial_states"], self.loops)
        return [(s, k % members) for k, s in enumerate(random_starts(system, x_des, count, self.task["start_seed"]))]

    @property
    def conditions(self) -> Conditions:
        """What disturbs the loop."""
        names = ("mismatch", "mismatch_kind", "noise", "disturbance", "delay")
        return Conditions(**{name: self.task[name] for name in names}, damping=tuple(self.task["damping"]))


def drive(
    folder: Path,
    model: Model,
    parameters: np.ndarray,
    seeds: Sequence[int],
    system: System,
    data: Dataset,
    plan: Plan,
    progress: Callable[[float, str], None],
) -> dict[str, Any]:
    """Close every loop of a plan with the members' weights (member, n_parameters)."""
    few = data.train
    samples = few.q[0][:PRIOR_SAMPLES], few.qd[0][:PRIOR_SAMPLES], few.qdd[0][:PRIOR_SAMPLES]
    obstacle = plan.obstacle(system)
    setting = Setting(plan.control, PredictiveModel(model, system, plan.canonical), obstacle, samples)
    rows, trajectories = [], []
    try:
        starts = plan.starts(system, len(seeds))
        for number, (start, member) in enumerate(starts):
            progress(number / len(starts), f"closed loop {number + 1} of {len(starts)}")
            loop = _close(setting, system, parameters[member], start, plan, obstacle)
            rows.append(row(loop, seeds[member], plan.control, plan.task))
            if number < SHOWN:
                trajectories += [(number, seeds[member], *point) for point in trajectory(loop, obstacle)]
            if number == 0:
                keep(folder / FIRST, loop, obstacle)
    finally:
        setting.close()
    table = pd.DataFrame(rows)
    table.to_parquet(folder / LOOPS, index=False)
    columns = ["loop", "member", "x_des", "name", "t", "value"]
    pd.DataFrame(trajectories, columns=columns).to_parquet(folder / TRAJECTORIES, index=False)
    return {
        "loops": len(rows),
        "success": float(table["success"].mean()),
        "contacts": int(table["contact"].sum()),
        "killed": int(table["killed"].sum()),
    }


def _close(
    setting: Setting, system: System, weights: np.ndarray, start: Start, plan: Plan, obstacle: Obstacle | None
) -> ClosedLoop:
    controller = setting.controller(wrong_weights(weights, plan.conditions, start), start.x_des)
    return run_loop(
        system,
        controller,
        start,
        plan.conditions,
        time_step=plan.control["time_step"],
        seconds=plan.task["seconds"],
        disc=obstacle,
    )
