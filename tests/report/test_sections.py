import re

import pytest

from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.errors import UserError
from repro.report.paper import load_figures, load_paper, paper_folder
from repro.report.placeholders import Texts
from repro.report.sections import HEADINGS, load_sections
from repro.results.metric_names import metric_named
from repro.results.results import Results, typed
from repro.results.table_schema import TABLES
from repro.tracking.paths import project_folder

PAPER = paper_folder()
TEXTS = sorted((PAPER / "report").rglob("*.md"))
EXPERIMENT_FILES = {path.stem for path in (project_folder() / "experiments").glob("*.yaml")} | {"timing"}


@pytest.fixture(scope="module")
def claims():
    return load_claims(PAPER / "claims.yaml")


@pytest.fixture(scope="module")
def nothing():
    return Results(**{name: typed(name, []) for name in TABLES})


@pytest.fixture
def fill(tmp_path, claims):
    """fill(text, results): the text with its placeholders filled."""

    def filled(text, results):
        (tmp_path / "here.md").write_text(text, encoding="utf-8")
        return Texts(tmp_path, results, judge_all(claims, results)).fill("here.md")

    return filled


@pytest.fixture
def sections(claims, nothing):
    return load_sections(Texts(PAPER / "report", nothing, judge_all(claims, nothing)))


def test_a_claim_stands_in_one_section_at_most(claims, sections):
    """One that somebody adds stands among the others until a section names it."""
    shown = [name for section in sections for name in section.claims]
    assert len(set(shown)) == len(shown)
    assert set(shown) <= {claim.name for claim in claims}


def test_sections_name_figures_and_tables_that_exist(sections):
    tables = {query.name for query in load_paper(PAPER).tables} | {"timing", "changes"}
    for section in sections:
        assert set(section.tables) <= tables, section.id
        assert set(section.figures) <= {figure.name for figure in load_figures(PAPER)}, section.id


def test_tables_are_of_experiments_that_exist():
    paper = load_paper(PAPER)
    assert {one.experiment for one in (*paper.tables, *paper.front_tables)} <= EXPERIMENT_FILES


def test_every_text_names_experiments_and_metrics_that_exist():
    for path in TEXTS:
        for kind, experiment, metric in re.findall(r'(metric|ratio|loops)\("(\w+)"(?:, "([^"]+)")?', path.read_text()):
            assert experiment in EXPERIMENT_FILES, (path.name, experiment)
            assert kind == "loops" or metric_named(metric).meaning != metric, (path.name, metric)


def test_nothing_run_is_written_as_not_run(sections):
    texts = [part.text for section in sections for part in section.parts]
    assert not re.search(r"[{}]", "".join(texts))
    assert "not run" in "".join(texts)
    assert "reason is not the objective's" not in "".join(texts)  # stands behind a condition


def test_numbers_come_from_the_store(store, fill):
    run = {"basis": "t2", "hidden": "10", "optimiser": "adam", "objective": "inverse"}
    store.run("sip_basis", {"mae_tau": [0.2, 0.25, 0.3, 0.35, 0.4]}, **run)
    stored = store.gathered()
    assert fill("{{ claim.C4a }}", stored) == r"0.3 \[0.2, 0.4\] N, N m (consistent)"
    assert fill("{{ claim.C4a.printed }} {{ claim.C4a.median }} {{ claim.C4a.members }}", stored) == "0.26 0.3 5"
    assert fill('{{ metric("sip_basis", "mae_tau", basis="t2", hidden=10) }}', stored).startswith("0.3 ")
    assert fill('{{ metric("sip_basis", "mae_tau", basis="t1") }}', stored) == "not run"
    assert fill('{{ runs() }} {{ runs("sip_basis") }} {{ runs("chains") }}', stored) == "1 1 not run"


def test_a_ratio_is_taken_seed_by_seed(store, fill):
    store.run("sip_basis", {"mae_tau": [1.0, 2.0, 3.0, 4.0, 5.0]}, hidden="10")
    store.run("sip_basis", {"mae_tau": [2.0, 4.0, 6.0, 8.0, 10.0]}, hidden="2x32")
    text = '{{ ratio("sip_basis", "mae_tau", {"hidden": 10}, {"hidden": "2x32"}) }}'
    assert fill(text, store.gathered()) == r"0.5 \[0.5, 0.5\]"


def test_loops_are_counted(fill):
    control = [{"experiment": "sip_control", "setting": "sip", "success": done} for done in (True, False, True)]
    results = Results(**{name: typed(name, {"control": control}.get(name, [])) for name in TABLES})
    text = '{{ loops("sip_control", setting="sip") }}; {{ loops("sip_control", setting="x") }}'
    assert fill(text, results) == "2 of 3; not run"


def test_conditions_drop_sentences_items_and_paragraphs(nothing, fill, claims):
    text = """First.
{% if claim.C4a.holds %}
Dropped.
{% endif %}
{% if (claim.C4a.not_run or claim.C4a.consistent) and claim.C5a.not_run %}
One of {{ claim | length }}.
{% endif %}

{% if claim.C4a.consistent %}
- dropped item
{% endif %}
{% if claim.C4a.not_run %}
- item
{% endif %}

{% if claim.C4a.fails %}
Dropped paragraph.
{% endif %}

Last."""
    assert fill(text, nothing) == f"First.\nOne of {len(claims)}.\n\n- item\n\nLast."


@pytest.mark.parametrize(
    "mistake",
    [
        *("{{ claim.C99 }}", "{{ claim.C4a.mean }}", '{{ metric("sip_basis") }}', "{{ nonsense }}", "{{ claim.C4a"),
        *("{% if claim.C4a.true %} x {% endif %}", '{{ loops("a", colour="red") }}', '{{ cost("dollars") }}'),
    ],
)
def test_a_mistake_in_a_text_names_file_and_line(mistake, nothing, fill):
    with pytest.raises(UserError, match=r"here.md, line 3: "):
        fill(f"One.\n\n{mistake}", nothing)


def test_a_section_without_its_head_is_an_error(tmp_path, nothing):
    place = tmp_path / "sections" / "01-lost.md"
    place.parent.mkdir()
    place.write_text("## Question\n\nWhat?\n")
    with pytest.raises(UserError, match="must begin with title"):
        load_sections(Texts(tmp_path, nothing, []))
    head = "---\ntitle: A\nfigures: []\ntables: []\nclaims: []\n---\n"
    place.write_text(f"{head}## Wondered\n\nWhat?\n")
    with pytest.raises(UserError, match=f"allowed: {', '.join(HEADINGS)}"):
        load_sections(Texts(tmp_path, nothing, []))
