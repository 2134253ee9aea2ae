import csv
import io

import pytest

from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.report.tables.every import all_tables, paired_table
from repro.report.tables.models import COMPARISONS, model_table, model_tables
from repro.report.tables.table import Column, Row, Table
from repro.report.writing import interval, latex, markdown, number
from repro.results.gather import gather
from repro.results.statistics import Estimate
from repro.tracking.paths import project_folder


@pytest.fixture(scope="module")
def tables(tmp_path_factory, synthetic):
    store = synthetic(tmp_path_factory.mktemp("tables") / "outputs", full=True)
    results = gather(store.outputs, "paper")
    claims = load_claims(project_folder() / "paper" / "claims.yaml")
    return {table.name: table for table in all_tables(results, judge_all(claims, results))}


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


def test_latex_is_escaped():
    assert latex("a_b & 5 % of {x} #1 $ ~ ^ \\") == (
        r"a\_b \& 5 \% of \{x\} \#1 \$ \textasciitilde{} \textasciicircum{} \textbackslash{}"
    )
    assert latex("5.3e-4 [∞]") == r"$5.3\times10^{-4}$ [$\infty$]"
    assert latex("sip-9e3") == "sip-9e3"


def test_markdown_cells_cannot_break_their_table():
    assert markdown("a|b_c\n<d>") == r"a\|b\_c \<d>"


def test_a_table_is_the_same_in_its_three_forms(tmp_path):
    table = Table(
        "t",
        "Title",
        "Caption",
        (Column("name"), Column("MAE τ", r"MAE$_\tau$")),
        (Row(("a_b", "1"), {"name": "a_b", "mae_tau": 1.0}, ("run-1",), ("repro run x=1",)),),
    )
    assert [path.name for path in table.save(tmp_path)] == ["t.csv", "t.md", "t.tex"]
    (row,) = csv.DictReader(io.StringIO((tmp_path / "t.csv").read_text(encoding="utf-8")))
    assert row == {"name": "a_b", "mae_tau": "1.0", "runs": "run-1", "command": "repro run x=1"}
    assert r"| a\_b | 1 | `repro run x=1` |" in (tmp_path / "t.md").read_text(encoding="utf-8")
    text = (tmp_path / "t.tex").read_text(encoding="utf-8")
    assert "% replay: repro run x=1\na\\_b & 1 \\\\" in text
    assert r"name & MAE$_\tau$ \\" in text


@pytest.mark.parametrize("name", [c.name for c in COMPARISONS if c.name != "selection"])
def test_every_table_of_models_has_the_three_anchor_rows_of_each_test_set(tables, name):
    anchors = [row for row in tables[name].rows if row.anchor]
    test_sets = {"regimes": 3, "dip_pretraining": 2}.get(name, 1)  # episodes (of 1000 and 100 steps), one long run
    assert len(anchors) == 3 * test_sets
    for title in ("trivial", "degenerate", "oracle"):
        assert sum(row.cells[0].startswith(title) for row in anchors) == test_sets


def test_an_anchor_that_was_not_run_says_so(store):
    store.run("sip_basis", {"mae_tau": [1.0, 2.0]})
    table = model_table(gather(store.outputs, "paper"), COMPARISONS[0])
    assert [row.cells[0].split(":")[-1] for row in table.rows if row.anchor] == [" not run"] * 3


def test_every_row_of_models_knows_its_runs_and_its_command(tables):
    for comparison in COMPARISONS:
        for row in tables[comparison.name].rows:
            if not row.cells[0].endswith("not run"):
                assert row.runs, row.cells
                assert row.commands[0].startswith("repro run"), row.cells


def test_an_experiment_of_ones_own_has_a_table_without_being_named(store):
    store.run("sip_of_my_own", {"mae_tau": [1.0, 2.0]})
    (table,) = model_tables(gather(store.outputs, "paper"))
    assert table.name == "sip_of_my_own"
    assert [row.anchor for row in table.rows] == [False, True, True, True]


def test_no_force_error_stands_alone(tables):
    titles = [column.title for column in tables["bases"].columns]
    for needed in ("MAE τ", "MAE q̈", "median AE q̈", "MAE H Legendre", "MAE L raw", "MAE L canonical", "min eig M"):
        assert needed in titles


def test_members_that_diverged_are_counted_in_their_row(tables):
    table = tables["forward_inverse"]
    failed = [column.title for column in table.columns].index("failed")
    objective = [column.title for column in table.columns].index("objective")
    counts = {(row.cells[objective], row.cells[failed]) for row in table.rows if not row.anchor}
    assert counts == {("inverse", "0"), ("forward", "1")}


def test_objectives_are_paired_member_by_member(store):
    store.run("sip_forward_inverse", {"mae_tau": [1.0, 2.0, 4.0], "mae_qdd": [1.0, 1.0, 1.0]})
    store.run("sip_forward_inverse", {"mae_tau": [4.0, 8.0, 16.0], "mae_qdd": [2.0, 2.0, 2.0]}, objective="forward")
    (row,) = paired_table(gather(store.outputs, "paper")).rows
    assert row.data["mae_tau_ratio"] == pytest.approx(0.25)
    assert row.data["mae_qdd_high"] == pytest.approx(0.5)
    assert len(row.runs) == 2


def test_what_failed_is_a_table_of_its_own(tables):
    (row,) = tables["failures"].rows
    assert row.cells[2:] == ("failed", "MemoryError: no room")


def test_the_claims_have_the_fixed_columns(tables):
    rows = list(csv.DictReader(io.StringIO(tables["verdicts"].csv())))
    fixed = ["id", "metric", "unit", "printed", "ours", "ci_low", "ci_high", "n", "verdict", "runs", "command"]
    assert [column for column in rows[0] if column in fixed] == fixed
    assert {row["verdict"] for row in rows} >= {"matched", "not run", "not comparable"}


def test_selection_shows_the_share_of_exact_supports(tables):
    table = tables["selection"]
    share = [column.title for column in table.columns].index("exact support")
    assert table.rows[0].cells[share].startswith("0.8 [")
