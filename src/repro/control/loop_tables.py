"""Closed loops as tables: one row a loop, and the trajectories of a few."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.control.closed_loop import SUBSTEPS, ClosedLoop
from repro.control.geometry import Disc
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System


def row(loop: ClosedLoop, seed: int, control: Mapping[str, Any], task: Mapping[str, Any]) -> dict[str, Any]:
    """One row of control.parquet: what was asked, what came of it, what it cost."""
    outcome = loop.outcome
    milliseconds = 1e3 * np.array([decision.seconds for decision in loop.steps])
    median, p95, p99 = (float(np.percentile(milliseconds, share)) for share in (50, 95, 99))
    fallbacks = np.array([decision.fallback for decision in loop.steps])
    length = control.get("intervals", 0) * control["time_step"]
    length += control.get("coarse_intervals", 0) * control.get("coarse_step", 0.0)
    begun = {f"start_{c.name}": value for c, value in zip(loop.plant.coordinates, loop.start.state, strict=False)}
    return {
        "member": seed,
        "controller": control["kind"],
        "setting": control["name"],
        "intervals": control.get("intervals", 0) + control.get("coarse_intervals", 0),
        "horizon_s": length,
        "adaptive": bool(control.get("adaptive", False)),
        "discretisation": control.get("discretisation", ""),
        "solver": control.get("solver", ""),
        "task": task["name"],
        "x_des": loop.start.x_des,
        "start": loop.start.name,
        **begun,
        "seconds": task["seconds"],
        **{name: task[name] for name in ("mismatch", "mismatch_kind", "noise", "disturbance", "delay")},
        "friction": "-".join(f"{value:g}" for value in task["damping"]),
        "success": outcome.success,
        "contact": outcome.contact,
        "clearance_min_m": outcome.clearance,
        "held_from_s": outcome.held_from,
        "steady_error_m": outcome.steady_error,
        "solve_ms_median": median,
        "solve_ms_p95": p95,
        "solve_ms_p99": p99,
        "iterations_median": float(np.median([decision.iterations for decision in loop.steps])),
        "fallbacks": int(np.sum(fallbacks > 0)),
        **{f"fallbacks_{level}": int(np.sum(fallbacks == level)) for level in (1, 2, 3)},
        "killed": sum(decision.killed for decision in loop.steps),
    }


def trajectory(loop: ClosedLoop, disc: Disc | None) -> Iterator[tuple[float, str, float, float]]:
    """State, energies, force, clearance and the links' ends at every control step, as (x_des, name, t, value).

    The disc's centre and radius come first, at t = 0.
    """
    if disc is not None:
        for name, value in zip(("x", "y", "radius"), (*disc.centre, disc.radius), strict=True):
            yield loop.start.x_des, f"obstacle.{name}", 0.0, value
    every = slice(None, None, SUBSTEPS)
    time, states = loop.time[every], loop.states[every]
    names = [c.name for c in loop.plant.coordinates]
    columns = dict(zip([*names, *(f"{name}d" for name in names)], states.T, strict=True))
    columns |= energies(loop.plant, states)
    columns["force"] = np.append(loop.forces, np.full(len(time) - len(loop.forces), np.nan))
    if loop.clearance is not None:
        columns["clearance"] = loop.clearance[every]
    points = loop.plant.body_points(list(states[:, : loop.plant.n_q].T), np)
    for number, (x, y) in enumerate(points[1:], start=1):
        columns |= {f"end{number}.x": x, f"end{number}.y": y}
    for name, values in columns.items():
        yield from ((loop.start.x_des, name, float(t), float(value)) for t, value in zip(time, values, strict=True))


def energies(system: System, states: np.ndarray) -> dict[str, np.ndarray]:
    """T, V and H of the plant along states (n, 2 n_q)."""
    q, qd = states[:, : system.n_q], states[:, system.n_q :]
    dynamics = dynamics_of(system)
    kinetic, potential = (evaluate(function, q, qd)[:, 0] for function in (dynamics.kinetic, dynamics.potential))
    return {"T": kinetic, "V": potential, "H": kinetic + potential}


def keep(path: Path, loop: ClosedLoop, disc: Disc | None) -> None:
    """All of the first loop, for its recording."""
    plans = [decision.plan for decision in loop.steps]
    longest = max(len(plan) for plan in plans)
    predicted = np.full((len(plans), longest, loop.states.shape[1]), np.nan)
    for k, plan in enumerate(plans):
        if len(plan):
            predicted[k, : len(plan)] = plan
    np.savez_compressed(
        path,
        time=loop.time,
        states=loop.states,
        forces=loop.forces,
        clearance=np.zeros(0) if loop.clearance is None else loop.clearance,
        predicted=predicted,
        iterations=[decision.iterations for decision in loop.steps],
        fallbacks=[decision.fallback for decision in loop.steps],
        milliseconds=[1e3 * decision.seconds for decision in loop.steps],
        obstacle=np.zeros(0) if disc is None else [*disc.centre, disc.radius],
        x_des=loop.start.x_des,
    )
