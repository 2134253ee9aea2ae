import json
import time
from dataclasses import replace

import pytest
from synthetic_runs import NOT_DRAWN

from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.report.content import Content
from repro.report.paper import load_figures, load_paper, paper_folder
from repro.report.pdf.document import document
from repro.report.pdf.page_table import page_table
from repro.report.pdf.prose import blocks
from repro.report.pdf.typeset import typeset
from repro.report.placeholders import Texts
from repro.report.sections import load_sections
from repro.report.tables.cost import cost_fact, cost_table
from repro.report.tables.every import all_tables
from repro.report.tables.table import Row, Table
from repro.results.results import Results, typed
from repro.results.table_schema import TABLES

PAPER = paper_folder()
FIGURES = tuple(figure for figure in load_figures(PAPER) if figure.name not in NOT_DRAWN)
SOURCE = PAPER / "report"


def content_of(results, figures=()):
    verdicts = judge_all(load_claims(PAPER / "claims.yaml"), results)
    paper, texts = load_paper(PAPER), Texts(SOURCE, results, verdicts)
    tables, assumptions = all_tables(results, verdicts, paper), load_assumptions(PAPER / "assumptions.yaml")
    return Content(paper, results, verdicts, tables, figures, load_sections(texts), assumptions, texts)


@pytest.fixture(scope="module")
def nothing():
    return Results(**{name: typed(name, []) for name in TABLES})


@pytest.fixture(scope="module")
def body(results):
    return document(content_of(results, FIGURES))


def test_the_same_content_gives_the_same_bytes(built, body):
    first, second = (typeset(body, built.figures, SOURCE) for _ in range(2))
    assert first == second
    assert first.startswith(b"%PDF")


def test_nothing_run_still_makes_a_paper(nothing, tmp_path):
    body = document(content_of(nothing))
    assert typeset(body, tmp_path, SOURCE).startswith(b"%PDF")
    assert body["counts"] == [("not run", len(body["claims"]["rows"]))] or {"not run"} < {n for n, _ in body["counts"]}


def test_what_no_section_names_stands_among_the_others(nothing):
    content = content_of(nothing)
    left = replace(content, sections=content.sections[:1])
    others = document(left)["sections"][-1]
    assert others["title"] == "Other experiments"
    assert [claim["name"] for claim in others["claims"]] == [verdict.claim.name for verdict in content.verdicts]


def test_no_placeholder_is_left(body):
    text = json.dumps([body["sections"], *(body[name] for name in ("abstract", "limits", "cost", "replay"))])
    assert not any(mark in text for mark in ("{{", "{%", "}}", "%}"))


def test_tables_and_figures_are_numbered_in_reading_order(body):
    figures = [entry["number"] for section in body["sections"] for entry in section["figures"]]
    figures += [entry["number"] for entry in body["trials"]]
    assert figures == list(range(1, len(FIGURES) + 1))
    tables = [entry["number"] for section in body["sections"] for entry in section["tables"]]
    assert tables == sorted(tables)
    everything = [body["claims"]["number"], *tables, body["answers"]["number"], body["runs"]["number"]]
    everything += [
        entry["number"] for entry in (body["sensitivity"], body["failures"], body["costs"], *body["appendix"]) if entry
    ]
    assert sorted(everything) == list(range(1, len(everything) + 1))


def test_prose_keeps_emphasis_code_and_lists():
    assert blocks("A *b* `c`\nd\n\n- e\n- **f**") == [
        {
            "kind": "paragraph",
            "spans": [
                {"text": "A ", "style": "plain"},
                {"text": "b", "style": "emphasis"},
                {"text": " ", "style": "plain"},
                {"text": "c", "style": "code"},
                {"text": " ", "style": "plain"},
                {"text": "d", "style": "plain"},
            ],
        },
        {"kind": "list", "items": [[{"text": "e", "style": "plain"}], [{"text": "f", "style": "strong"}]]},
    ]


def table(titles, *rows):
    return Table("t", "T", "C", tuple(titles), tuple(Row(cells=row, data={}) for row in rows))


def test_what_names_a_row_becomes_one_column_and_what_all_share_is_said_once():
    titles = ("basis", "hidden", "noise", "tau noise", "epochs", "MAE τ", "skill τ", "members")
    first = ("T2/V1", "1x10", "false", "0", "1000", "0.131 [0.105, 0.191]", "0.9", "10")
    second = ("T1/V1", "", "true", "0.1", "0", "0.2", "0.8", "10")
    shown = page_table(table(titles, first, second))
    assert shown["titles"] == ["setting", "MAE τ"]
    assert [row[0]["main"] for row in shown["rows"]] == ["T2/V1, 1x10, epochs 1000", "T1/V1, noise, tau noise 0.1"]
    assert shown["rows"][0][1] == {"main": "0.131", "below": "[0.105, 0.191]"}
    assert shown["shared"] == "members 10"


def test_a_table_of_many_columns_turns_its_page():
    wide = [f"column {number}" for number in range(14)]
    first = tuple(f"{number}.123456e-10" for number in range(14))
    second = tuple(f"{number}.654321e-10" for number in range(14))
    assert page_table(table(wide, first, second))["landscape"]
    assert not page_table(table(wide[:4], first[:4], second[:4]))["landscape"]


def test_text_gets_the_room_that_numbers_leave():
    """Numbers have 0, a width that typst finds; the longer of two texts gets more."""
    first = ("a short text, of some words", "1.5 [1.2, 1.9]", "a long text " * 20)
    second = ("another text, of some words", "2.5 [2.2, 2.9]", "another long text " * 20)
    name, number, text = page_table(table(("what", "ratio", "protocol"), first, second))["widths"]
    assert number == 0
    assert 20 < name < text
    assert name + text < 128  # characters on a page


def test_a_shared_stage_is_paid_once(nothing):
    runs = [{"run": name, "experiment": name[0], "outcome": "ok"} for name in ("a1", "b1")]
    stages = [
        {"run": run, "stage": stage, "id": id, "cpu_s": 1800.0, "wall_s": 3600.0, "peak_memory_mib": 512.0}
        for run, stage, id in (("a1", "data", "d"), ("a1", "fit", "f"), ("b1", "data", "d"), ("b1", "fit", "g"))
    ]
    results = replace(nothing, runs=typed("runs", runs), stages=typed("stages", stages))
    assert cost_fact(results, "cpu_hours") == "1.5"
    with pytest.raises(ValueError, match="allowed: cpu_hours"):
        cost_fact(results, "dollars")
    assert [row.cells for row in cost_table(results).rows] == [
        ("a", "1", "1", "2", "512"),
        ("b", "1", "0.5", "1", "512"),
    ]


@pytest.mark.slow
def test_the_committed_results_make_a_small_paper_in_a_moment():
    figures = [figure for figure in FIGURES if (PAPER / "figures" / f"{figure.name}.pdf").is_file()]
    content = content_of(Results.load(PAPER / "results"), figures)
    began = time.process_time()
    made = typeset(document(content), PAPER / "figures", SOURCE)
    assert time.process_time() - began < 3.0
    assert len(made) < 5_000_000
