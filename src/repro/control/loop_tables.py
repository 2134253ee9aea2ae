"""Closed loops as tables: one row per loop, and the trajectories of a few."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from repro.control.closed_loop import SUBSTEPS, ClosedLoop
from repro.control.geometry import Disc
from repro.mechanics.derive import energies_along


def row(loop: ClosedLoop, seed: int) -> dict[str, str | int | float | bool | None]:
    """One row of control.parquet: the start of the loop and its outcome.

    seed: of the model that drives it. Columns start_NAME hold the initial coordinates.
    """
    outcome = loop.outcome
    milliseconds = 1e3 * np.array([step.seconds for step in loop.steps])
    median, p95, p99 = (float(np.percentile(milliseconds, share)) for share in (50, 95, 99))
    fallbacks = np.array([step.fallback for step in loop.steps])
    initial = {f"start_{c.name}": float(q) for c, q in zip(loop.plant.coordinates, loop.start.state, strict=False)}
    return {
        "member": seed,
        "x_des": loop.start.goal.place("x"),
        "start": loop.start.name,
        **initial,
        "success": outcome.success,
        "contact": outcome.contact,
        "clearance_min_m": outcome.clearance,
        "held_from_s": outcome.held_from,
        "steady_error_m": outcome.steady_error,
        "solve_ms_median": median,
        "solve_ms_p95": p95,
        "solve_ms_p99": p99,
        "iterations_median": float(np.median([step.iterations for step in loop.steps])),
        "fallbacks": int(np.sum(fallbacks > 0)),
        **{f"fallbacks_{level}": int(np.sum(fallbacks == level)) for level in (1, 2, 3)},
        "killed": sum(step.killed for step in loop.steps),
    }


def trajectory(loop: ClosedLoop, disc: Disc | None) -> Iterator[tuple[float, str, float, float]]:
    """State, energies, inputs, clearance and the ends of the links at every control step, as (x_des, name, t, value).

    Units: those of coordinates and inputs, m, J and s; x_des is nan where there is no coordinate x. The centre and
    radius of the disc come first, at t = 0.
    """
    place = loop.start.goal.place("x")
    if disc is not None:
        for name, value in zip(("x", "y", "radius"), (*disc.centre, disc.radius), strict=True):
            yield place, f"obstacle.{name}", 0.0, value
    every = slice(None, None, SUBSTEPS)
    time, states = loop.time[every], loop.states[every]
    names = [c.name for c in loop.plant.coordinates]
    columns = dict(zip([*names, *(f"{name}d" for name in names)], states.T, strict=True))
    columns |= energies_along(loop.plant, states)
    missing = np.full((len(time) - len(loop.steps), len(loop.plant.inputs)), np.nan)
    columns |= dict(zip((i.name for i in loop.plant.inputs), np.append(loop.inputs, missing, axis=0).T, strict=True))
    if loop.clearance is not None:
        columns["clearance"] = loop.clearance[every]
    points = loop.plant.body_points(list(states[:, : loop.plant.n_q].T), np)
    for number, (x, y) in enumerate(points[1:], start=1):
        columns |= {f"end{number}.x": x, f"end{number}.y": y}
    for name, values in columns.items():
        yield from ((place, name, float(t), float(value)) for t, value in zip(time, values, strict=True))


def save(path: Path, loop: ClosedLoop, disc: Disc | None) -> None:
    """Write all of a loop as .npz, for its recording."""
    plans = [step.plan for step in loop.steps]
    longest = max(len(plan) for plan in plans)
    predicted = np.full((len(plans), longest, loop.states.shape[1]), np.nan)
    for k, plan in enumerate(plans):
        if len(plan):
            predicted[k, : len(plan)] = plan
    np.savez_compressed(
        path,
        time=loop.time,
        states=loop.states,
        inputs=loop.inputs,
        clearance=np.zeros(0) if loop.clearance is None else loop.clearance,
        predicted=predicted,
        iterations=[step.iterations for step in loop.steps],
        fallbacks=[step.fallback for step in loop.steps],
        milliseconds=[1e3 * step.seconds for step in loop.steps],
        obstacle=np.zeros(0) if disc is None else [*disc.centre, disc.radius],
    )
