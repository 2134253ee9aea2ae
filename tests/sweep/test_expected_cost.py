import pytest

from repro.config.compose import compose
from repro.pipeline.plan import Pipeline
from repro.sweep.expected_cost import MeasuredStages, expected_mib, expected_seconds
from repro.tracking import index
from repro.tracking.index import Entry
from repro.tracking.paths import Paths
from repro.tracking.record import StageOutcome


def pipeline(*overrides):
    composed = compose([*overrides])
    return Pipeline.of(composed.config, composed.command)


def finished(stage, seconds, number=0, mib=0.0):
    fields = {"kind": stage.kind, "name": stage.name, "outcome": StageOutcome.OK, "command": stage.command}
    return Entry(f"{stage.name}-{number}", **fields, upstream={}, wall_s=seconds, peak_memory_mib=mib)


@pytest.fixture
def times(tmp_path, monkeypatch):
    """Measured times of these stages."""

    def make(*entries):
        monkeypatch.setattr(index, "load", lambda paths: index.Index([*entries], {}))
        return MeasuredStages(Paths(tmp_path))

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


def test_memory_is_the_largest_peak_of_its_name_and_scale_else_it_grows_with_the_data(times):
    nothing = times()
    few, many = (expected_mib(pipeline("scale=paper", f"data.samples={n}"), nothing) for n in (1000, 100_000))
    assert 300 < few < many < 1200
    assert few < expected_mib(pipeline("scale=paper", "data.samples=1000", "sequence=pretrain"), nothing)
    at_paper = pipeline("scale=paper")
    seen = times(*(finished(at_paper.run_stage, 1.0, number, mib) for number, mib in enumerate((700.0, 900.0, 800.0))))
    assert expected_mib(at_paper, seen) == 900.0
