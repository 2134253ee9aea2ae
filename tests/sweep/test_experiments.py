"""Every experiment says how to run it, composes at every scale, and runs."""

import json
import os
import re
import subprocess
import sys
from functools import cache

import pytest
import yaml

from repro.bench.stored_bench import EXPERIMENT
from repro.bench.suite import comparisons
from repro.claims.claims import load_claims
from repro.config.compose import parse, plan
from repro.config.overrides import REPRODUCED_AT, expand, experiments
from repro.config.places import CONF, EXPERIMENTS
from repro.config.registry import settings
from repro.config.schema import scaled
from repro.mechanics.system import load_system
from repro.sweep.planned_job import PlannedJob
from repro.tracking.paths import project_folder

CLAIMS = load_claims(project_folder() / "paper" / "claims.yaml")


@pytest.mark.parametrize("name", experiments())
def test_an_experiment_says_how_to_run_it_and_what_it_asks(name):
    command, question, *_ = (EXPERIMENTS / f"{name}.yaml").read_text().splitlines()
    assert command == f"# repro run -m experiment={name}"
    assert re.match(r"# .*\((C\d+|.*; C\d+|[IVX]+-)", question), "the claims or the section that it answers"


@cache
def jobs_of(name):
    return plan(expand([f"experiment={name}", "scale=paper"]))


def at_scale(composed, scale):
    """The configuration of a job at a scale, without composing it again."""
    if scale == composed.config.scale.name:
        return scaled(composed.config)
    return scaled(parse(composed.config.model_dump() | {"scale": settings("scale", scale)}))


@pytest.mark.parametrize("name", experiments())
def test_all_jobs_compose_at_every_scale(name):
    jobs = jobs_of(name)
    for composed in jobs:
        for scale in ("smoke", "quick", "paper"):
            config = at_scale(composed, scale)
            assert config.experiment == name
            assert config.optimiser.unit is None or config.optimiser.length >= 1
    planned = [PlannedJob.of(composed) for composed in jobs]
    asked = [claim for claim in CLAIMS if claim.experiment == name]
    unanswered = [claim.name for claim in asked if not any(job.answers(claim) for job in planned)]
    assert not unanswered, "claims that no job of the experiment answers"
    driven = all(composed.config.control.kind != "none" for composed in jobs)
    systems = {composed.config.system_options.name: load_system(composed.config.system_options) for composed in jobs}
    cyclic = any(coordinate.cyclic for system in systems.values() for coordinate in system.coordinates)
    anchors = {"truth"} if driven else {"trivial", "degenerate"} if cyclic else {"trivial"}
    assert anchors <= {composed.config.model.kind for composed in jobs}, "the anchor rows"


def test_a_reproduction_leaves_out_what_is_reproduced_at_other_scales_alone():
    scales = {path.stem for path in (CONF / "scale").glob("*.yaml")}
    listed = {
        name: yaml.safe_load((EXPERIMENTS / f"{name}.yaml").read_text()).get(REPRODUCED_AT) for name in experiments()
    }
    assert set().union(*filter(None, listed.values())) <= {*scales, "name"}  # the last: by its name alone
    for scale in scales:
        included = set(experiments(scale))
        assert {name for name, some in listed.items() if some and scale not in some} == set(experiments()) - included
    assert set(experiments("paper")) == {name for name, some in listed.items() if some != ["name"]}
    assert experiments("paper") != experiments("smoke")


def test_the_smallest_scale_leaves_out_long_motions_and_long_chains():
    def longest(scale):
        configs = [at_scale(job, scale) for name in ("ph_passivity", "chains") for job in jobs_of(name)]
        links = [number for config in configs for number in (*config.chain, *config.whole_chain)]
        return max(horizon for config in configs for horizon in config.energies.horizons), max(links)

    assert longest("smoke") == (2, 10)
    assert longest("quick") == (100, 10_000)


def test_every_claim_on_timing_names_a_comparison_that_is_made():
    asked = {claim.predicate.bench["name"] for claim in CLAIMS if claim.experiment == EXPERIMENT}
    assert asked <= {comparison.name for comparison in comparisons("smoke")}


@pytest.mark.slow
def test_all_experiments_run_and_a_second_pass_repeats_nothing(tmp_path):
    environment = {**os.environ, "REPRO_OUTPUTS": str(tmp_path)}

    def repro(*arguments):
        command = [sys.executable, "-m", "repro", *arguments]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def made():
        files = [*tmp_path.glob("*/*/run.json"), *(tmp_path / "report" / "smoke").rglob("*.*")]
        return {path: path.stat().st_mtime_ns for path in files}

    repro("reproduce", "scale=smoke")
    before = made()
    states = {item["id"]: item["state"] for item in json.loads(repro("status", "--json"))}
    assert set(states.values()) == {"done"}
    listed = {path.stem for path in (tmp_path / "experiments" / "smoke").iterdir()}
    assert listed == {*experiments("paper"), EXPERIMENT}  # the benchmark is listed as one

    repro("reproduce", "scale=smoke")
    assert made() == before
