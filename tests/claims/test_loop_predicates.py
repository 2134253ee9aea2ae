import json
from dataclasses import replace

import pytest
from pydantic import TypeAdapter
from synthetic_loops import EXPERIMENT, loop, results

from repro.claims.claims import Predicate
from repro.claims.evidence import Evidence
from repro.results.selectors import NotRunError


def judged(results, parameters):
    return TypeAdapter(Predicate).validate_python(parameters).judge(Evidence(results, EXPERIMENT))


@pytest.mark.parametrize(
    ("successes", "outcome", "leans"),
    [(40, "holds", True), (37, "open", True), (35, "open", False), (20, "fails", False)],
)
def test_the_share_of_loops_that_succeed(successes, outcome, leans):
    stored = results([loop(k, k < successes) for k in range(40)])
    finding = judged(stored, {"name": "loops_succeed", "share_of_loops": 0.9, "loops": {"setting": "sip"}})
    assert (finding.decision.outcome, finding.decision.leans) == (outcome, leans)
    assert (finding.estimate.median, finding.estimate.n) == (successes / 40, 40)
    assert (
        finding.estimate.low < successes / 40
        and finding.runs == ("run-1",)
        and finding.commands == ("repro run run-1",)
    )


def test_more_often_means_interval_against_interval():
    parameters = {
        "name": "loops_succeed_more_often", "loops": {"setting": "sip"}, "other_loops": {"setting": "set_point_square"}
    }  # fmt: skip
    ours = [loop(k, True) for k in range(20)]

    def others(successes):
        return [loop(k, k < successes, setting="set_point_square", run="run-2") for k in range(20)]

    assert judged(results(ours + others(2)), parameters).decision.outcome == "holds"
    assert judged(results(ours + others(18)), parameters).decision.outcome == "open"
    assert set(judged(results(ours + others(2)), parameters).runs) == {"run-1", "run-2"}


def test_both_sides_are_tuned_on_the_same_starts_and_compared_on_others():
    def run(name, setting, intervals, seed, successes):
        loops = [loop(k, k < successes, setting=setting, intervals=intervals, run=name) for k in range(20)]
        return loops, {"control.intervals": intervals, "task.start_seed": seed}

    made = [
        run("a-20-1", "sip", 20, 1, 5), run("a-40-1", "sip", 40, 1, 20),
        run("a-20-2", "sip", 20, 2, 20), run("a-40-2", "sip", 40, 2, 19),
        run("b-20-1", "tracking", 20, 1, 9), run("b-40-1", "tracking", 40, 1, 3),
        run("b-20-2", "tracking", 20, 2, 2), run("b-40-2", "tracking", 40, 2, 20),
    ]  # fmt: skip
    stored = results([each for loops, _ in made for each in loops])
    configs = {loops[0]["run"]: json.dumps(config) for loops, config in made}
    stored = replace(stored, runs=stored.runs.assign(config=stored.runs["run"].map(configs)))
    found = judged(
        stored,
        {
            "name": "loops_succeed_more_often", "loops": {"setting": "sip"}, "other_loops": {"setting": "tracking"},
            "tuned_by": ["control.intervals"], "tuned_on": {"task.start_seed": 1}, "judged_on": {"task.start_seed": 2},
        },
    )  # fmt: skip
    assert (found.decision.outcome, found.estimate.median) == ("holds", 0.95)
    assert set(found.runs) == {"a-40-2", "b-20-2"}
    assert "control.intervals=40 against control.intervals=20" in found.note


def test_a_share_without_contact():
    stored = results([loop(k, False, contact=k < 4) for k in range(40)])
    predicate = {"name": "loops_succeed", "share_of_loops": 0.7, "loops": {"setting": "sip"}, "outcome": "no_contact"}
    found = judged(stored, predicate)
    assert (found.decision.outcome, found.estimate.median, found.quantity) == ("holds", 0.9, "no_contact")


def test_the_time_of_one_iteration():
    stored = results([loop(k, True) for k in range(5)])  # 10 to 14 ms for 5 iterations
    parameters = {"name": "iteration_takes_longer", "loops": {"model": "truth"}}
    assert judged(stored, {**parameters, "milliseconds": 1.9}).decision.outcome == "holds"
    assert judged(stored, {**parameters, "milliseconds": 2.9}).decision.outcome == "fails"


def test_step_times():
    stored = results([loop(k, True) for k in range(5)])
    parameters = {"name": "step_takes_longer", "loops": {"model": "truth"}}
    assert judged(stored, {**parameters, "milliseconds": 9.5}).decision.outcome == "holds"
    assert judged(stored, {**parameters, "milliseconds": 12.0}).decision.outcome == "open"
    assert judged(stored, {**parameters, "milliseconds": 14.0}).decision.outcome == "fails"


def test_what_was_not_run_is_said():
    parameters = {"name": "loops_succeed", "share_of_loops": 0.9, "loops": {"setting": "dip"}}
    for stored in (results([]), results([loop(0, True)])):
        with pytest.raises(NotRunError, match="no closed loop of sip_control with setting=dip"):
            judged(stored, parameters)
