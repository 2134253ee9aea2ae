import json
import re
from dataclasses import replace

import pytest

from repro.claims.assumption_effects import assumption_effects
from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.report.paper import load_figures, load_paper, paper_folder
from repro.report.pdf.document import document, typeset
from repro.report.pdf.prose import blocks
from repro.report.placeholders import Texts
from repro.report.sections import Content, load_sections
from repro.report.tables.cost import cost_fact, cost_table
from repro.report.tables.every import all_tables
from repro.results.results import Results, typed
from repro.results.table_schema import TABLES
from repro.tracking.files import read_yaml

PAPER = paper_folder()
FIGURES = load_figures(PAPER)
SOURCE = PAPER / "report"


def content_of(results, figures=()):
    verdicts = judge_all(load_claims(PAPER / "claims.yaml"), results)
    paper, texts = load_paper(PAPER), Texts(SOURCE, results, verdicts)
    tables, assumptions = all_tables(results, verdicts, paper), load_assumptions(PAPER / "assumptions.yaml")
    tried = results.sensitivity
    effects = assumption_effects(tried, [verdict.claim for verdict in verdicts]) if tried is not None else []
    return Content(paper, results, verdicts, effects, tables, figures, assumptions, load_sections(texts), texts)


@pytest.fixture(scope="module")
def nothing():
    return Results(**{name: typed(name, []) for name in TABLES})


@pytest.fixture(scope="module")
def body(results):
    return document(content_of(results, FIGURES))


def test_the_same_content_gives_the_same_bytes(built, body):
    first, second = (typeset(body, built.folder / "figures", SOURCE) for _ in range(2))
    assert first == second
    assert first.startswith(b"%PDF")


def test_nothing_run_still_makes_a_paper(nothing, tmp_path):
    body = document(content_of(nothing))
    assert typeset(body, tmp_path, SOURCE).startswith(b"%PDF")
    assert not body["claims"]
    assert "not run" in {name for name, _ in body["counts"]}


def test_no_placeholder_is_left(body):
    text = json.dumps(
        [
            body["sections"],
            *(body[name] for name in ("abstract", "introduction", "discussion", "limits", "cost", "replay")),
        ]
    )
    assert not any(mark in text for mark in ("{{", "{%", "}}", "%}"))


def test_every_claim_stands_in_the_paper_or_among_those_not_run(body):
    named = [row["claim"] for row in body["claims"]] + body["not_run"]
    assert sorted(named) == sorted(claim.name for claim in load_claims(PAPER / "claims.yaml"))


def test_only_assumptions_that_move_a_claim_are_printed(body):
    assert all(row["moves"] for row in body["assumptions"])
    printed = {row["id"] for row in body["assumptions"]} | set(body["other_assumptions"])
    assert printed == {row.id for row in load_assumptions(PAPER / "assumptions.yaml")}


def test_every_citation_is_in_the_bibliography_and_every_entry_is_cited_and_complete():
    entries = read_yaml(SOURCE / "references.yaml")
    cited = set(re.findall(r"@(\w+)", "".join(path.read_text() for path in (SOURCE / "texts").glob("*.md"))))
    assert cited == set(entries)
    assert len(entries) >= 30
    for entry in entries.values():
        assert {"type", "title", "author", "date"} <= set(entry)
        assert {"parent", "publisher"} & set(entry)  # a venue, or who published a book


def test_sections_cite_nothing_because_the_pages_show_them_too():
    assert not [path.name for path in (SOURCE / "sections").glob("*.md") if "[@" in path.read_text()]


def test_a_citation_is_a_span_of_its_own():
    assert blocks("A [@b2020 @c2021].") == [
        {
            "kind": "paragraph",
            "spans": [
                {"text": "A ", "style": "plain"},
                {"text": "b2020 c2021", "style": "citation"},
                {"text": ".", "style": "plain"},
            ],
        }
    ]


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
def test_the_committed_results_make_a_small_paper():
    figures = [figure for figure in FIGURES if (PAPER / "figures" / f"{figure.name}.pdf").is_file()]
    content = content_of(Results.load(PAPER / "results"), figures)
    made = typeset(document(content), PAPER / "figures", SOURCE)
    assert len(made) < 5_000_000
