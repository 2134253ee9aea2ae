"""The vocabulary in which a statement on control is asked of stored closed loops."""

from typing import TYPE_CHECKING

import numpy as np

from repro.claims.predicates import Evidence, Outcome
from repro.results.schema import as_text, plain
from repro.results.selectors import NotRunError, Where
from repro.results.statistics import Estimate, estimate, share

if TYPE_CHECKING:
    import pandas as pd


def loops_succeed(evidence: Evidence, *, share_of_loops: float, loops: Where) -> Outcome:
    """Hold when at least this share of the closed loops succeeds: erect for the last 2 s, and no contact."""
    chosen = _chosen(evidence, loops)
    found = share(chosen["success"].to_numpy(dtype=bool))
    touched = int(chosen["contact"].sum())
    note = f"asked: at least {share_of_loops:g}; {len(chosen)} closed loops, {touched} with contact"
    return _outcome(found.median >= share_of_loops, "success", "1", found, note, evidence, chosen)


def loops_succeed_more_often(evidence: Evidence, *, loops: Where, other_loops: Where) -> Outcome:
    """Hold when the share of successes lies above that of the others, interval against interval."""
    chosen, others = _chosen(evidence, loops), _chosen(evidence, other_loops)
    ours, other = (share(table["success"].to_numpy(dtype=bool)) for table in (chosen, others))
    note = (
        f"asked: more often than the others, whose share is {other.median:.3g} [{other.low:.3g}, {other.high:.3g}] "
        f"of {other.n} closed loops"
    )
    import pandas as pd

    both = pd.concat([chosen, others])
    return _outcome(ours.low > other.high, "success", "1", ours, note, evidence, both)


def step_takes_longer(evidence: Evidence, *, milliseconds: float, loops: Where) -> Outcome:
    """Hold when the median control step of the median closed loop takes longer (CPU time)."""
    chosen = _chosen(evidence, loops)
    found = estimate(chosen["solve_ms_median"].to_numpy(dtype=float), log=True)
    note = f"asked: above {milliseconds:g} ms; {len(chosen)} closed loops"
    return _outcome(found.median > milliseconds, "solve_ms_median", "ms", found, note, evidence, chosen)


def _chosen(evidence: Evidence, loops: Where) -> "pd.DataFrame":
    chosen = evidence.results.control
    chosen = chosen[chosen["experiment"] == evidence.experiment]
    for column, wanted in loops.items():
        texts = {as_text(value) for value in (wanted if isinstance(wanted, list) else [wanted])}
        chosen = chosen[np.array([as_text(plain(value)) in texts for value in chosen[column]], dtype=bool)]
    if chosen.empty:
        asked = ", ".join(f"{column}={as_text(value)}" for column, value in loops.items())
        raise NotRunError(f"no closed loop of {evidence.experiment} with {asked}")
    return chosen


def _outcome(
    holds: bool, quantity: str, unit: str, found: Estimate, note: str, evidence: Evidence, chosen: "pd.DataFrame"
) -> Outcome:
    runs = tuple(dict.fromkeys(chosen["run"]))
    rows = evidence.results.runs
    commands = dict.fromkeys(rows[rows["run"].isin(runs)]["command"])
    return Outcome(bool(holds), quantity, unit, found, note, runs=runs, commands=tuple(c for c in commands if c))
