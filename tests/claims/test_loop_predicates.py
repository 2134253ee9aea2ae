import pytest
from pydantic import TypeAdapter
from synthetic_loops import EXPERIMENT, loop, results

from repro.claims.evidence import Evidence
from repro.claims.predicate import Predicate
from repro.results.selectors import NotRunError


def judged(results, parameters):
    return TypeAdapter(Predicate).validate_python(parameters).judge(Evidence(results, EXPERIMENT))


@pytest.mark.parametrize(("successes", "holds"), [(10, True), (9, True), (8, False)])
def test_the_share_of_loops_that_succeed(successes, holds):
    stored = results([loop(k, k < successes) for k in range(10)])
    finding = judged(stored, {"name": "loops_succeed", "share_of_loops": 0.9, "loops": {"setting": "sip"}})
    assert (finding.holds, finding.estimate.median, finding.estimate.n) == (holds, successes / 10, 10)
    assert (
        finding.estimate.low < successes / 10
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

    assert judged(results(ours + others(2)), parameters).holds
    assert not judged(results(ours + others(18)), parameters).holds
    assert set(judged(results(ours + others(2)), parameters).runs) == {"run-1", "run-2"}


def test_step_times():
    stored = results([loop(k, True) for k in range(5)])
    parameters = {"name": "step_takes_longer", "loops": {"model": "truth"}}
    assert judged(stored, {**parameters, "milliseconds": 11.5}).holds
    assert not judged(stored, {**parameters, "milliseconds": 12.0}).holds


def test_what_was_not_run_is_said():
    parameters = {"name": "loops_succeed", "share_of_loops": 0.9, "loops": {"setting": "dip"}}
    for stored in (results([]), results([loop(0, True)])):
        with pytest.raises(NotRunError, match="no closed loop of sip_control with setting=dip"):
            judged(stored, parameters)
