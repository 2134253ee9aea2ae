import json
from functools import cache

import pytest

from repro.config.compose import compose
from repro.config.overrides import expand
from repro.errors import UserError
from repro.results.gather import gather
from repro.results.selectors import NotRunError, one_setting
from repro.results.stored import read_stored
from repro.sweep import listing
from repro.sweep.listing import list_jobs
from repro.sweep.planned_job import PlannedJob
from repro.tracking.experiment_list import ExperimentList
from repro.tracking.paths import Paths


@cache
def planned():
    """Two jobs of the experiment."""
    return [PlannedJob.of(compose(job)) for job in expand(["experiment=sip_selection", "scale=smoke"])[:2]]


@pytest.fixture
def paths(tmp_path):
    return Paths(tmp_path)


@pytest.fixture
def file(paths):
    return paths.experiments / "smoke" / "sip_selection.json"


def test_jobs_stay_listed_as_long_as_they_belong_to_the_experiment(paths, file):
    first, second = planned()
    list_jobs(paths, [first])
    list_jobs(paths, [second])
    stored = ExperimentList.read(file)
    assert {job.run for job in stored.jobs} == {first.run, second.run}
    foreign = {"overrides": ["experiment=sip_selection", "basis=raw"], "run": "x", "command": "y"}
    content = json.loads(file.read_bytes())
    file.write_text(json.dumps({**content, "jobs": [*content["jobs"], foreign]}))
    list_jobs(paths, [first])
    assert {job.run for job in ExperimentList.read(file).jobs} == {first.run, second.run}


def test_what_another_command_lists_meanwhile_stays(paths, file, monkeypatch):
    first, second = planned()
    own, others = listing._extended, iter([second])

    def extended(path, jobs):
        found = own(path, jobs)
        for other in others:  # after this command has read the list, before it writes
            list_jobs(paths, [other])
        return found

    monkeypatch.setattr(listing, "_extended", extended)
    list_jobs(paths, [first])
    assert {job.run for job in ExperimentList.read(file).jobs} == {first.run, second.run}
    assert sorted(path.name for path in file.parent.glob("[!.]*")) == [file.name]


def test_a_run_that_is_not_there_is_described_by_the_list(paths, file):
    list_jobs(paths, planned()[:1])
    results = gather(read_stored(paths.root, "smoke"))
    (row,) = results.runs.to_dict("records")
    assert (row["outcome"], row["system"], row["model"], row["episode_steps"]) == ("missing", "sip", "trivial", 100)
    with pytest.raises(NotRunError, match=f"^{row['run']} missing"):
        one_setting(results, "sip_selection", {"model": "trivial", "data.force_limit": 5})


def test_ids_are_made_anew_when_the_settings_have_changed(paths, file):
    first, second = planned()
    list_jobs(paths, [first, second])
    content = json.loads(file.read_bytes())
    file.write_text(
        json.dumps({**content, "settings": "of before", "jobs": [{**job, "run": "old"} for job in content["jobs"]]})
    )
    list_jobs(paths, [first])
    assert {job.run for job in ExperimentList.read(file).jobs} == {first.run, second.run}


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"jobs": 1}', '{"jobs": [{"run": "x"}]}'])
def test_a_damaged_list_is_one_clear_error(paths, file, content):
    file.parent.mkdir(parents=True)
    file.write_text(content)
    with pytest.raises(UserError, match=r"^.*sip_selection.json cannot be read .*; delete it"):
        list_jobs(paths, planned()[:1])
