import csv
import io
import math
from dataclasses import replace

import pytest

from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.report.paper import load_paper, paper_folder
from repro.report.tables.every import all_tables, timing_table
from repro.report.tables.models import ModelTable, plain_tables
from repro.report.tables.table import Row, Table
from repro.report.writing import interval, markdown, number
from repro.results.gather import gather
from repro.results.statistics import Estimate
from repro.results.stored import read_stored

PAPER = load_paper(paper_folder())
QUERIES = {query.name: query for query in PAPER.tables}
MODELS = [name for name, query in QUERIES.items() if isinstance(query, ModelTable)]


@pytest.fixture(scope="module")
def tables(results):
    claims = load_claims(paper_folder() / "claims.yaml")
    return {table.name: table for table in all_tables(results, judge_all(claims, results), PAPER)}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.26, "0.26"),
        (39.393, "39.4"),
        (999.6, "1000"),
        (1421.7, "1422"),
        (5.30e-4, "5.3e-4"),
        (1e-13, "1e-13"),
        (2.5e7, "2.5e7"),
        (0.0, "0"),
        (float("nan"), "–"),
        (None, "–"),
        (float("inf"), "∞"),
    ],
)
def test_numbers_have_three_figures(value, text):
    assert number(value) == text


def test_an_interval_is_left_out_where_there_is_none():
    nan = float("nan")
    assert interval(Estimate(0.2, 0.1, 0.3, 5)) == "0.2 [0.1, 0.3]"
    assert interval(Estimate(0.2, nan, nan, 1)) == "0.2"


def test_markdown_cells_cannot_break_their_table():
    assert markdown("a|b_c\n<d>") == r"a\|b\_c \<d>"


def test_a_race_shows_what_was_reached_and_from_how_many_starts(store):
    row = {"name": "race", "ours": "a", "other": "b", "size": "1x10", "members": 1, "metric": "MAE_H", "goal": 0.01}
    reached = {"starts": 5, "ours_reached": 5, "other_reached": 0, "ours_ms": 40.0, "other_ms": math.inf}
    ratios = dict.fromkeys(("ratio_median", "ratio_q25", "ratio_q75", "ratio_least", "ratio_greatest"), math.inf)
    store.bench(
        [row | reached | ratios, {"name": "step", "size": "1x10", "members": 1, "ratio_median": 2.0, "ours_ms": 1}]
    )
    table = timing_table(gather(read_stored(store.outputs, "paper")))
    raced, step = (dict(zip(table.columns, each.cells, strict=True)) for each in table.rows)
    assert (raced["until"], raced["reached by ours, other"]) == ("MAE_H 0.01", "5, 0 of 5")
    assert (raced["ours [ms]"], raced["other [ms]"]) == ("40", "not reached")
    assert (step["until"], step["reached by ours, other"], step["other [ms]"]) == ("", "", "–")


def test_a_table_is_written_with_the_command_behind_each_row(tmp_path):
    row = Row(("a|b", "1"), {"name": "a|b", "mae_tau": 0.1 + 0.2}, ("run-1",), ("repro run x=1",))
    Table("t", "Title", "Caption", ("name", "MAE τ"), (row,)).save(tmp_path)
    (stored,) = csv.DictReader(io.StringIO((tmp_path / "t.csv").read_text(encoding="utf-8")))
    assert stored == {"name": "a|b", "mae_tau": str(0.1 + 0.2), "runs": "run-1", "command": "repro run x=1"}
    assert r"| a\|b | 1 | `repro run x=1` |" in (tmp_path / "t.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [name for name in MODELS if name != "selection"])
def test_every_table_of_models_has_the_three_anchor_rows_of_each_test_set(tables, name):
    anchors = [row for row in tables[name].rows if row.anchor]
    test_sets = {"regimes": 3, "dip_pretraining": 2}.get(name, 1)  # episodes (of 1000 and 100 steps), one long run
    assert len(anchors) == 3 * test_sets
    for title in ("trivial", "degenerate", "oracle"):
        assert sum(row.cells[0].startswith(title) for row in anchors) == test_sets


def test_an_anchor_that_was_not_run_says_so(store):
    store.run("sip_basis", {"mae_tau": [1.0, 2.0]})
    table = QUERIES["bases"].make(store.gathered())
    assert [row.cells[0].split(":")[-1] for row in table.rows if row.anchor] == [" not run"] * 3


def test_every_row_of_models_knows_its_runs_and_its_command(tables):
    for name in MODELS:
        for row in tables[name].rows:
            if not row.cells[0].endswith("not run"):
                assert row.runs, row.cells
                assert row.commands[0].startswith("repro run"), row.cells


def test_an_experiment_of_ones_own_has_a_table_without_being_named(store):
    store.run("sip_of_my_own", {"mae_tau": [1.0, 2.0]})
    (table,) = plain_tables(store.gathered(), set())
    assert table.name == "sip_of_my_own"
    assert [row.anchor for row in table.rows] == [False, True, True, True]


def test_no_force_error_stands_alone(tables):
    titles = tables["bases"].columns
    for needed in ("MAE τ", "MAE q̈", "median AE q̈", "MAE H Legendre", "MAE L raw", "MAE L canonical", "min eig M"):
        assert needed in titles


def test_members_that_diverged_are_counted_in_their_row(tables):
    table = tables["forward_inverse"]
    failed = table.columns.index("failed")
    objective = table.columns.index("objective")
    counts = {(row.cells[objective], row.cells[failed]) for row in table.rows if not row.anchor}
    assert counts == {("inverse", "0"), ("forward", "1")}


def test_objectives_are_paired_member_by_member(store):
    store.run("sip_forward_inverse", {"mae_tau": [1.0, 2.0, 4.0, 8.0, 16.0], "mae_qdd": [1.0] * 5})
    store.run(
        "sip_forward_inverse", {"mae_tau": [4.0, 8.0, 16.0, 32.0, 64.0], "mae_qdd": [2.0] * 5}, objective="forward"
    )
    (row,) = QUERIES["forward_inverse_paired"].make(store.gathered()).rows
    assert row.data["mae_tau_ratio"] == pytest.approx(0.25)
    assert row.data["mae_qdd_high"] == pytest.approx(0.5)
    assert len(row.runs) == 2


def test_changes_of_the_claims_name_their_commit_and_reason(tables):
    rows = tables["changes"].rows
    assert {row.data["id"] for row in rows} >= {"C11a", "C11b", "C11c", "C13a"}
    assert all(len(row.data["commit"]) >= 7 and row.data["reason"] for row in rows)


def test_what_failed_is_a_table_of_its_own(tables):
    (row,) = tables["failures"].rows
    assert row.cells[2:] == ("failed", "MemoryError: no room")


def test_the_claims_have_the_fixed_columns(tables):
    rows = list(csv.DictReader(io.StringIO(tables["verdicts"].csv())))
    fixed = ["id", "metric", "unit", "printed", "ours", "ci_low", "ci_high", "n", "verdict", "runs", "command"]
    assert [column for column in rows[0] if column in fixed] == fixed
    assert {row["verdict"] for row in rows} >= {"consistent", "not run", "not comparable"}


def test_selection_shows_the_share_of_exact_supports(tables):
    """Four of five members of each optimiser."""
    (share,) = {row.data["support_exact"] for row in tables["selection"].rows if not row.anchor and row.data["n"]}
    assert share == 0.8


def test_pairs_of_equal_budgets_count_what_the_first_wins(store):
    """Pretraining 300 epochs and then 1000 is compared with 1300 epochs, and with no other number of them."""
    pretrained = {"sequence": "pretrain", "pretraining_epochs": 300, "epochs": 1000, "grid": "product of 100"}
    store.run("dip_pretraining", {"mae_tau": [1.0, 2.0, 9.0]}, **pretrained)
    store.run("dip_pretraining", {"mae_tau": [4.0, 4.0, 4.0]}, sequence="main", epochs=1300)
    store.run("dip_pretraining", {"mae_tau": [0.1, 0.1, 0.1]}, sequence="main", epochs=1000)
    store.run("dip_pretraining", {"mae_tau": [0.1, 0.1, 0.1]}, sequence="pretrain", epochs=1000)
    query = replace(QUERIES["pretraining_paired"], metrics=("mae_tau",))
    (row,) = query.make(store.gathered()).rows
    assert row.data["mae_tau_ratio"] == pytest.approx(0.5)
    assert (row.data["mae_tau_wins"], row.data["n"]) == (2, 3)
    assert row.cells[-2:] == ("2 of 3", "3")
