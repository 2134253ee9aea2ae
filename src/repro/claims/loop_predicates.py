"""Statements about closed loops. The unit of a share is what is drawn: the learned model, else start, target, plant."""

from contextlib import suppress
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field

from repro.claims.evidence import Decision, Evidence, Finding, LoopSelector, Ruling, StatementPredicate, Value
from repro.claims.yaml_rows import Number, Text
from repro.results.selectors import NotRunError, find_loops, in_words, loops_of_one_setting
from repro.results.statistics import FEWEST, Estimate, estimate, share
from repro.tracking.lazy_pandas import pd

Unit = Literal["member", "loop"]
Readings = dict[str, Annotated[list[Value], Field(min_length=2)]]


class LoopsSucceed(StatementPredicate):
    """At least this share of the closed loops succeeds: erect for the last 2 s, and no contact.

    readings: one setting with the values that the paper leaves open; each is judged by itself, and all must agree.
    """

    name: Literal["loops_succeed"]
    loops: LoopSelector
    share_of_loops: Number
    outcome: Literal["success", "no_contact"] = "success"  # or the share without contact is meant, erect or not
    readings: Annotated[Readings, Field(max_length=1)] = Field(default_factory=dict)
    reference: LoopSelector = Field(default_factory=dict)  # named beside them, such as those with the true model
    unit: Unit | None = None  # what is drawn; a loop with a model that is not learned, else a member

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the share of successes with the bound."""
        if not self.readings:
            return self._judged(evidence, {})
        judged: dict[str, Finding | None] = {}
        readings: list[LoopSelector] = [{key: value} for key, values in self.readings.items() for value in values]
        for reading in readings:
            judged[in_words(reading)] = None
            with suppress(NotRunError):
                judged[in_words(reading)] = self._judged(evidence, reading)
        run = [found for found in judged.values() if found is not None]
        if not run:
            raise NotRunError(f"no closed loop of {evidence.experiment} with any of the readings")
        notes = "; ".join(f"{reading}: {found.note if found else 'not run'}" for reading, found in judged.items())
        return replace(
            max(run, key=lambda found: found.estimate.median),
            decision=_together([found.decision if found else None for found in judged.values()]),
            note=f"criterion: at least {self.share_of_loops:g}; the best reading is shown. {notes}",
            rows=[{**row, "as_printed": False} for found in run for row in found.rows],
        )

    def _judged(self, evidence: Evidence, reading: LoopSelector) -> Finding:
        selected = self._loops(evidence, {**self.loops, **reading})
        successes = _successes(selected, self.unit)
        decision = Decision.at_least(successes, self.share_of_loops)
        note = (
            f"{int(selected['success'].sum())} of {len(selected)} loops, {int(selected['contact'].sum())} with contact"
        )
        if reading:
            note += f", {successes.n} units, share {successes.median:.2g} [{successes.low:.2g}, {successes.high:.2g}]"
            decision = Decision(Ruling.OPEN, decision.leans) if successes.n < FEWEST else decision
        else:
            note = f"criterion: at least {self.share_of_loops:g}; {note}"
        if self.reference:
            with suppress(NotRunError):
                loops = self._loops(evidence, {**self.reference, **reading})
                note += f" ({in_words(self.reference)}: {int(loops['success'].sum())} of {len(loops)})"
        rows = evidence.run_rows(selected["run"])
        return Finding(self.outcome, "1", successes, note, rows, decision=decision)

    def _loops(self, evidence: Evidence, selector: LoopSelector) -> "pd.DataFrame":
        """The loops of a selector, by the outcome that is meant."""
        loops = _selected(evidence, selector)
        return loops if self.outcome == "success" else loops.assign(success=~loops["contact"].astype(bool))


class LoopsSucceedMoreOften(StatementPredicate):
    """The share of successes lies above that of `other_loops`, interval against interval.

    tuned_by: settings that both sides choose by the same procedure: the values with the largest share of successes in
    the loops of `tuned_on`; compared are then those of `judged_on`.
    """

    name: Literal["loops_succeed_more_often"]
    loops: LoopSelector
    other_loops: LoopSelector
    tuned_by: list[Text] = Field(default_factory=list)
    tuned_on: LoopSelector = Field(default_factory=dict)
    judged_on: LoopSelector = Field(default_factory=dict)
    unit: Unit | None = None

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the intervals of both shares."""
        selected, chosen = self._tuned(evidence, self.loops)
        others, other_chosen = self._tuned(evidence, self.other_loops)
        ours, other = _successes(selected, self.unit), _successes(others, self.unit)
        note = f"criterion: more often than the others, whose share is {other.median:.3g} "
        note += f"[{other.low:.3g}, {other.high:.3g}] of {other.n}"
        if self.tuned_by:
            note += f"; tuned: {in_words(chosen)} against {in_words(other_chosen)}"
        rows = evidence.run_rows([*selected["run"], *others["run"]])
        return Finding("success", "1", ours, note, rows, other, decision=Decision.greater(ours, other))

    def _tuned(self, evidence: Evidence, loops: LoopSelector) -> "tuple[pd.DataFrame, LoopSelector]":
        """The loops that are compared, and the values chosen for them."""
        if not self.tuned_by:
            return _selected(evidence, loops), {}
        trials = find_loops(evidence.results, evidence.experiment, {**loops, **self.tuned_on})
        if trials.empty:
            raise NotRunError(f"no closed loop of {evidence.experiment} with {in_words({**loops, **self.tuned_on})}")
        shares = trials.groupby("run", sort=False)["success"].mean()
        settings = evidence.results.configs[str(shares.idxmax())]
        chosen: LoopSelector = {key: settings[key] for key in self.tuned_by}
        return _selected(evidence, {**loops, **self.judged_on, **chosen}), chosen


class TimeTakesLonger(StatementPredicate):
    """The median control step, or one iteration of its solver, takes longer (CPU time): the median over what is drawn.

    A solver that is stopped within its first iteration needs at least the time of the step for one.
    """

    name: Literal["step_takes_longer", "iteration_takes_longer"]
    loops: LoopSelector
    milliseconds: Number
    unit: Unit | None = None

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the median of the median times."""
        selected = _selected(evidence, self.loops)
        taken = selected["solve_ms_median"]
        if self.name == "iteration_takes_longer":
            taken = taken / selected["iterations_median"].clip(lower=1)
        timed = selected.assign(taken=taken)
        measured = estimate(_by_unit(timed, self.unit)["taken"].median().tolist())
        note = f"criterion: above {self.milliseconds:g} ms; {len(selected)} closed loops"
        decision = Decision.above(measured, self.milliseconds)
        quantity = "solve_ms_median" if self.name == "step_takes_longer" else "ms_per_iteration"
        rows = evidence.run_rows(selected["run"])
        return Finding(quantity, "ms", measured, note, rows, decision=decision)


LoopPredicate = LoopsSucceed | LoopsSucceedMoreOften | TimeTakesLonger


def _together(decisions: list[Decision | None]) -> Decision:
    """All readings alike, or it depends on the reading; open where one was not run or is open."""
    known = [decision for decision in decisions if decision is not None]
    outcomes = {decision.outcome for decision in known} - {Ruling.OPEN}
    leans = all(decision.leans for decision in known)
    if len(outcomes) > 1:
        return Decision(Ruling.DEPENDS, leans)
    settled = len(known) == len(decisions) and all(decision.outcome is not Ruling.OPEN for decision in known)
    return Decision(outcomes.pop() if settled else Ruling.OPEN, leans)


def _by_unit(loops: "pd.DataFrame", unit: Unit | None) -> "pd.api.typing.DataFrameGroupBy[Any, Any]":
    """The loops by what was drawn: several loops of one member are one unit."""
    by_loop = unit == "loop" or (unit is None and bool((loops["model"] == "truth").all()))
    columns = ["run", "start", "x_des"] if by_loop else ["member"]
    return loops.groupby(columns, sort=False, dropna=False)


def _successes(loops: "pd.DataFrame", unit: Unit | None) -> Estimate:
    return share(_by_unit(loops, unit)["success"].mean().tolist())


def _selected(evidence: Evidence, selector: LoopSelector) -> "pd.DataFrame":
    loops = loops_of_one_setting(evidence.results, evidence.experiment, selector)
    if loops.empty:
        raise NotRunError(f"no closed loop of {evidence.experiment} with {in_words(selector)}")
    return loops
