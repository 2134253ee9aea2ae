"""Statements about stored closed loops."""

from typing import TYPE_CHECKING, Literal

from repro.claims.evidence import Evidence, Finding, StatementPredicate
from repro.claims.selector import LoopSelector, Selector
from repro.claims.yaml_rows import Number
from repro.results.schema import as_text
from repro.results.selectors import NotRunError, find_loops
from repro.results.statistics import Estimate, estimate, share

if TYPE_CHECKING:
    import pandas as pd


class LoopsSucceed(StatementPredicate):
    """At least this share of the closed loops succeeds: erect for the last 2 s, and no contact."""

    name: Literal["loops_succeed"]
    loops: LoopSelector
    share_of_loops: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the share of successes."""
        selected = _selected(evidence, self.loops)
        successes = _successes(selected)
        note = f"asked: at least {self.share_of_loops:g}; {len(selected)} closed loops, "
        note += f"{int(selected['contact'].sum())} with contact"
        holds = successes.median >= self.share_of_loops
        return _finding(holds, "success", "1", successes, note, evidence, selected)


class LoopsSucceedMoreOften(StatementPredicate):
    """The share of successes lies above that of `other_loops`, interval against interval."""

    name: Literal["loops_succeed_more_often"]
    loops: LoopSelector
    other_loops: LoopSelector

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the intervals of both shares."""
        import pandas as pd

        selected, others = _selected(evidence, self.loops), _selected(evidence, self.other_loops)
        ours, other = _successes(selected), _successes(others)
        note = f"asked: more often than the others, whose share is {other.median:.3g} "
        note += f"[{other.low:.3g}, {other.high:.3g}] of {other.n} closed loops"
        holds = ours.low > other.high
        return _finding(holds, "success", "1", ours, note, evidence, pd.concat([selected, others]))


class StepTakesLonger(StatementPredicate):
    """The median control step of the median closed loop takes longer (CPU time)."""

    name: Literal["step_takes_longer"]
    loops: LoopSelector
    milliseconds: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the median of the loops' median step times."""
        selected = _selected(evidence, self.loops)
        measured = estimate(selected["solve_ms_median"].to_numpy(dtype=float), log=True)
        note = f"asked: above {self.milliseconds:g} ms; {len(selected)} closed loops"
        holds = measured.median > self.milliseconds
        return _finding(holds, "solve_ms_median", "ms", measured, note, evidence, selected)


def _successes(loops: "pd.DataFrame") -> Estimate:
    return share(loops["success"].to_numpy(dtype=bool))


def _selected(evidence: Evidence, selector: Selector) -> "pd.DataFrame":
    loops = find_loops(evidence.results, evidence.experiment, selector)
    if loops.empty:
        described = ", ".join(f"{column}={as_text(value)}" for column, value in selector.items())
        raise NotRunError(f"no closed loop of {evidence.experiment} with {described}")
    return loops


def _finding(
    holds: bool, quantity: str, unit: str, estimate: Estimate, note: str, evidence: Evidence, loops: "pd.DataFrame"
) -> Finding:
    runs = tuple(dict.fromkeys(loops["run"]))
    rows = evidence.results.runs
    commands = dict.fromkeys(rows[rows["run"].isin(runs)]["command"])
    return Finding(bool(holds), quantity, unit, estimate, note, runs, tuple(filter(None, commands)))
