"""`repro reproduce`: where its timings are taken."""

from types import SimpleNamespace

import pytest

from repro import __main__ as cli
from repro.commands import reproduce
from repro.launch.jobs import JobOutcome, JobResult
from repro.report import build, terminal
from repro.results import stored


@pytest.mark.parametrize(
    ("scale", "unfinished", "place"),
    [("smoke", True, "beside"), ("smoke", False, "alone"), ("quick", True, "alone"), ("paper", True, "alone")],
)
def test_only_those_of_the_smallest_scale_are_taken_beside_jobs(monkeypatch, tmp_path, scale, unfinished, place):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))
    places = []

    def run(jobs, paths, workers, first):
        if not unfinished:
            return []
        places.extend("beside" for job in first if job.arguments["scale"] == scale)
        return [JobResult(job, JobOutcome.OK) for job in (*first, *jobs)]

    for name in ("plan_sample", "plan_jobs"):
        monkeypatch.setattr(reproduce, name, lambda *given: [SimpleNamespace()])
    monkeypatch.setattr(reproduce, "list_jobs", lambda *given: None)
    monkeypatch.setattr(reproduce, "run_missing", run)
    monkeypatch.setattr(reproduce, "_time", lambda *given: places.append("alone") or True)
    monkeypatch.setattr(stored, "stale_runs", lambda root: set())
    monkeypatch.setattr(build, "build", lambda *given, **options: None)
    monkeypatch.setattr(terminal, "show", lambda summary: None)
    assert cli.main(["reproduce", f"scale={scale}"]) == 0
    assert places == [place]
