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


def test_the_stage_whose_command_is_nearest_decides(times):
    few, many = (pipeline("scale=paper", "control=sip", f"task.initial_states={n}", "task=random") for n in (1, 9))
    near = finished(many.control_stage, 400.0)
    far = finished(few.control_stage, 20.0, 1)._replace(name=many.control_stage.name)
    assert times(near, far).seconds(many.control_stage, 0.0) == 400.0


def test_a_stage_that_was_resumed_does_not_count_as_done_in_no_time(times):
    stage = pipeline("control=sip").control_stage
    assert times(finished(stage, 0.0)).seconds(stage, 50.0) == 5.0


def test_what_several_jobs_share_is_expected_once(times):
    """A beginning on D_H, and a fit that several closed loops use; what is stored is expected of none."""
    settings = ("scale=paper", "system=dip", "basis=fxf", "sequence=pretrain")
    first, other = (pipeline(*settings, *more) for more in ((), ("data.force_limit=4",)))
    alone = expected_seconds(other, times())
    begun = {first.pretraining_stage.id}
    assert 0 < expected_seconds(other, times(), begun) < alone
    assert expected_seconds(other, times(), begun | {other.fit_stage.id}) == 0


def test_iterations_cost_by_weights(times):
    """Normal equations: as the square of their number."""
    settings = ("scale=paper", "system=dip", "model=structured", "optimiser=levenberg_marquardt")
    small, large = (expected_seconds(pipeline(*settings, f"model.hidden=[{n}]"), times()) for n in (4, 16))
    assert large > 4 * small
