"""What lists, experiments and pairs make of a command line."""

import pytest

from repro.config.overrides import EXPERIMENT, belongs, check, expand, experiments, parsed, setting
from repro.config.places import CONF
from repro.config.registry import read_settings
from repro.errors import UserError

RENAMED = read_settings(CONF / "renamed.yaml")


def test_lists_multiply():
    jobs = expand(["basis=t1,t2", "seeds=3", "objective=forward,inverse"])
    assert len(jobs) == 4
    assert ("basis=t1", "seeds=3", "objective=inverse") in jobs


def test_brackets_are_values_not_lists_of_jobs():
    assert expand(["seeds=[0,1]", "model.hidden=[32,32]"]) == [("seeds=[0,1]", "model.hidden=[32,32]")]
    assert expand(["seeds=[0,1],[2,3]"]) == [("seeds=[0,1]",), ("seeds=[2,3]",)]
    assert expand(["seeds=range(1,4)"]) == [("seeds=1",), ("seeds=2",), ("seeds=3",)]


def test_paired_lists_walk_side_by_side():
    jobs = expand(["basis=t1,t2", "objective=forward,inverse", "seeds=3"], paired=True)
    assert jobs == [("basis=t1", "objective=forward", "seeds=3"), ("basis=t2", "objective=inverse", "seeds=3")]
    with pytest.raises(UserError, match="one length: 2 in basis=t1,t2, 3 in seeds=1,2,3"):
        expand(["basis=t1,t2", "seeds=1,2,3"], paired=True)


@pytest.mark.parametrize("name", experiments())
def test_an_experiment_is_its_lines(name):
    jobs = expand([f"experiment={name}", "scale=smoke"])
    assert len(jobs) > 1
    assert len(set(jobs)) == len(jobs)
    assert all(job[-2:] == (EXPERIMENT + name, "scale=smoke") for job in jobs)
    assert jobs == expand([f"+experiment={name}", "scale=smoke"])


def test_what_is_given_replaces_what_a_line_says():
    jobs = expand(["experiment=sip_basis", "optimiser=least_squares", "seeds=7"])
    assert all([o for o in job if o.startswith("optimiser=")] == ["optimiser=least_squares"] for job in jobs)


def test_several_experiments_follow_each_other():
    one, other = experiments()[:2]
    assert set(expand([f"experiment={one},{other}"])) == {
        *expand([f"experiment={one}"]),
        *expand([f"experiment={other}"]),
    }


def test_a_job_belongs_to_its_experiment_with_more_seeds_but_not_with_other_settings():
    job = expand(["experiment=sip_basis"])[-1]
    assert belongs(job)
    assert belongs([*job, "seeds=[7,8]", "scale=paper", "record=false"])
    assert not belongs([*job, "data.tau_noise=0.3"])
    assert not belongs(["basis=t1", "optimiser=least_squares"])
    assert setting([*job, "seeds=3"]) == setting(job)


@pytest.mark.parametrize("old", [*(f"{key}=1" for key in RENAMED["keys"]), *RENAMED["options"]])
def test_a_name_of_the_first_version_is_answered_with_the_present_one(old):
    key = old.partition("=")[0]
    new = RENAMED["keys"].get(key) or RENAMED["options"][old]
    with pytest.raises(UserError, match=f"called .*{new}"):
        check([old])


@pytest.mark.parametrize("value", ["t1", "-1e-5", "1.5", "null", "true", "two-words", "a.b"])
def test_a_plain_value_is_no_list_in_hydras_grammar_either(value):
    assert expand([f"data.key={value}"]) == [(f"data.key={value}",)]
    assert not parsed(f"data.key={value}").is_sweep_override()
