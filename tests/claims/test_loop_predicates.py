import pytest
from pydantic import TypeAdapter
from synthetic_loops import EXPERIMENT, loop, results

from repro.claims.evidence import Evidence
from repro.claims.predicate import Predicate
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
