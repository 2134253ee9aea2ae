"""The report's texts and claims on the runs that the experiments plan: every selector in them means one setting."""

import json
import re
from dataclasses import replace

import pytest

from repro.bench.stored_bench import EXPERIMENT as BENCH
from repro.claims.claims import load_claims
from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import judge_all
from repro.config.compose import plan
from repro.config.overrides import expand, experiments
from repro.pipeline.card import card_of
from repro.report import placeholders
from repro.report.paper import paper_folder
from repro.results.gather import Gathering
from repro.results.metric_names import metric_named
from repro.results.results import Results, typed
from repro.results.table_schema import TABLES
from repro.tracking.plain_data import digest

PAPER = paper_folder()
TEXTS = PAPER / "report"
MEMBERS = 5
NAMED = re.compile(r'(?:metric|ratio)\("(\w+)", "([\w@\[\]]+)"')
ONE_LOOP = {"member": 0, "success": True, "contact": False, "solve_ms_median": 1.0, "iterations_median": 1.0}


def metrics_in(value):
    """Every metric that a claim names, in its predicates too."""
    if isinstance(value, dict):
        named = {value["metric"]} if value.get("metric") else set(value.get("metrics") or ())
        return named.union(*map(metrics_in, value.values()))
    return set()


def rows_of(job, experiment, printed, metrics):
    """Rows of runs, metrics and control as a finished run of this job would have them; every value is 1."""
    config, card = job.config, card_of(job.config)
    share = int(config.data.samples * config.data.train_fraction)
    n_train = min(share, config.data.train_samples or share)
    card = replace(card, measured={"n_train": n_train, "epochs": card.settings.get("optimiser.epochs", 0)})
    setting, seeds = digest(card.settings)[:10], list(config.members)[:MEMBERS]
    run = {"run": job.command, "experiment": experiment, "scale": "paper", "setting": setting, **card.run_columns()}
    whole = {"as_printed": printed.is_as_printed(card.settings), "config": json.dumps(dict(card.settings))}
    whole |= {"changed": " ".join(sorted(card.changed)), "outcome": "ok", "stale": False, "command": job.command}
    whole |= {"seeds": seeds, "member_status": ["ok"] * len(seeds)}
    values = [
        {**run, "member": seed, "split": metric_named(name).split, "metric": name.partition("@")[0], "value": 1.0}
        for name in metrics
        for seed in seeds
    ]
    loops = [] if config.control.kind == "none" else [{**run, **card.loop_columns(), **ONE_LOOP}]
    return {**run, **whole}, values, loops


@pytest.fixture(scope="module")
def claims():
    return load_claims(PAPER / "claims.yaml")


@pytest.fixture(scope="module")
def planned(claims):
    """Results of every experiment of a reproduction at full length."""
    measured = {(name, metric) for path in TEXTS.rglob("*.md") for name, metric in NAMED.findall(path.read_text())}
    for claim in claims:
        places = {claim.experiment, claim.cure.experiment if claim.cure else None}
        measured |= {(place, metric) for place in places for metric in metrics_in(claim.model_dump())}
    printed, tables = Gathering.load(PAPER), {"runs": [], "metrics": [], "control": []}
    for experiment in {*experiments("paper")} | {name for name, _ in measured} & {*experiments()}:
        metrics = {metric for name, metric in measured if name == experiment}
        for job in plan(expand([f"experiment={experiment}", "scale=paper"])):
            run, values, loops = rows_of(job, experiment, printed, metrics)
            tables["runs"].append(run)
            tables["metrics"] += values
            tables["control"] += loops
    return Results(**{name: typed(name, tables.get(name, [])) for name in TABLES})


@pytest.mark.slow
def test_every_selector_means_one_planned_setting(planned, claims, monkeypatch):
    verdicts = judge_all(claims, planned)
    not_run = [v for v in verdicts if v.verdict is VerdictKind.NOT_RUN and v.claim.experiment != BENCH]
    assert not not_run, "\n".join(f"{verdict.claim.name}: {verdict.note}" for verdict in not_run)

    facts = placeholders._facts

    def every_condition_holds(verdict):
        forced = {"flag": "degenerate", "cure": "supported with changes", "not_run": False}
        found = facts(verdict)
        return {name: forced.get(name, True if isinstance(fact, bool) else fact) for name, fact in found.items()}

    monkeypatch.setattr(placeholders, "_facts", every_condition_holds)
    monkeypatch.setattr(placeholders, "_or_not_run", lambda read: read)  # what is missing or ambiguous is an error
    monkeypatch.setattr(placeholders, "cost_fact", lambda results, fact: fact)
    texts = placeholders.Texts(TEXTS, planned, verdicts)
    for name in (*texts.names("sections"), *texts.names("texts")):
        assert texts.fill(name)
