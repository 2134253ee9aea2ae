import pytest

from repro.config.compose import compose
from repro.pipeline.plan import Pipeline
from repro.sweep.expected_time import MeasuredTimes, expected_seconds
from repro.tracking import index
from repro.tracking.index import Entry
from repro.tracking.paths import Paths
from repro.tracking.record import StageOutcome


def pipeline(*overrides):
    composed = compose([*overrides])
    return Pipeline.of(composed.config, composed.command)


def finished(stage, seconds, number=0):
    fields = {"kind": stage.kind, "name": stage.name, "outcome": StageOutcome.OK, "command": stage.command}
    return Entry(f"{stage.name}-{number}", **fields, upstream={}, wall_s=seconds)


@pytest.fixture
def times(tmp_path, monkeypatch):
    """Measured times of these stages."""

    def make(*entries):
        monkeypatch.setattr(index, "load", lambda paths: index.Index([*entries], {}))
        return MeasuredTimes(Paths(tmp_path))

    return make


def test_without_finished_stages_the_size_decides(times):
    nothing = times()
    short, long = (expected_seconds(pipeline("optimiser.epochs=" + n), nothing) for n in ("10", "5000"))
    assert 0 < short < long
    one, many = (
        expected_seconds(
            pipeline("control=sip_best", "task=random", f"task.initial_states={n}", "scale=paper"), nothing
        )
        for n in (1, 9)
    )
    assert expected_seconds(pipeline("scale=paper"), nothing) < one < many
    assert expected_seconds(pipeline("model=trivial"), nothing) < short


def test_finished_stages_of_its_name_and_scale_decide(times):
    at_paper, at_quick = pipeline("scale=paper"), pipeline()
    fit = at_paper.fit_stage
    measured = times(*(finished(fit, seconds, number) for number, seconds in enumerate((50.0, 70.0, 900.0))))
    assert expected_seconds(at_paper, measured) == 70.0
    assert expected_seconds(at_quick, measured) == expected_seconds(at_quick, times())
