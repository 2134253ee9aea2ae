import re

import pytest

from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.errors import UserError
from repro.report.drawing import FIGURES
from repro.report.placeholders import fill
from repro.report.sections import HEADINGS, filled_sections, load_sections
from repro.report.tables.closed_loops import EXPERIMENTS
from repro.report.tables.every import paired_table, timing_table
from repro.report.tables.identifiability import identifiability_table
from repro.report.tables.models import COMPARISONS
from repro.report.tables.pretraining import pretraining_table
from repro.results.gather import gather
from repro.results.metric_names import METRICS
from repro.results.results import Results, typed
from repro.results.schema import TABLES
from repro.tracking.paths import project_folder

PAPER = project_folder() / "paper"
FOLDER = PAPER / "report" / "sections"
TEXTS = sorted((PAPER / "report").rglob("*.md"))
EXPERIMENT_FILES = {path.stem for path in (project_folder() / "experiments").glob("*.yaml")} | {"timing"}


@pytest.fixture(scope="module")
def claims():
    return load_claims(PAPER / "claims.yaml")


@pytest.fixture(scope="module")
def nothing():
    return Results(**{name: typed(name, []) for name in TABLES})


def filled(text, store, claims):
    results = gather(store.outputs, "paper")
    return fill(text, results, judge_all(claims, results), "here")


def test_a_claim_stands_in_one_section_at_most(claims):
    """One that somebody adds stands among the others until a section names it."""
    shown = [name for section in load_sections(FOLDER) for name in section.claims]
    assert len(set(shown)) == len(shown)
    assert set(shown) <= {claim.name for claim in claims}


def test_sections_name_figures_and_tables_that_exist(nothing):
    made = {builder(nothing).name for builder in (paired_table, timing_table, identifiability_table, pretraining_table)}
    tables = made | {comparison.name for comparison in COMPARISONS} | set(EXPERIMENTS) | EXPERIMENT_FILES
    for section in load_sections(FOLDER):
        assert set(section.tables) <= tables, section.id
        assert set(section.figures) <= {figure.name for figure in FIGURES}, section.id


def test_every_text_asks_for_experiments_and_metrics_that_exist():
    for path in TEXTS:
        for kind, rest in re.findall(r"\{(metric|ratio|loops) ([^{}]*)\}", path.read_text()):
            experiment, metric, *_ = rest.split()
            assert experiment in EXPERIMENT_FILES, (path.name, rest)
            assert kind == "loops" or re.sub(r"\[\d+\]|@free", "", metric) in METRICS, (path.name, rest)


def test_nothing_run_is_told_as_not_run(claims, nothing):
    verdicts = judge_all(claims, nothing)
    texts = [part.text for section in filled_sections(FOLDER, nothing, verdicts) for part in section.parts]
    assert not re.search(r"[{}]", "".join(texts))
    assert "not run" in "".join(texts)
    assert "reason is not the objective's" not in "".join(texts)  # stands behind a guard


def test_numbers_come_from_the_store(store, claims):
    run = {"basis": "t2", "hidden": "10", "optimiser": "adam", "objective": "inverse"}
    store.run("sip_basis", {"mae_tau": [0.2, 0.3, 0.4]}, **run)
    assert filled("{claim.C4a}", store, claims) == r"0.3 \[0.121, 0.685\] N, N m (matched)"
    assert filled("{claim.C4a.printed} {claim.C4a.median} {claim.C4a.members}", store, claims) == "0.26 0.3 3"
    assert filled("{metric sip_basis mae_tau basis=t2}", store, claims).startswith("0.3 ")
    assert filled("{metric sip_basis mae_tau basis=t1}", store, claims) == "not run"
    assert filled("{runs} {runs sip_basis} {runs chains}", store, claims) == "1 1 not run"
    assert filled("{claims}", store, claims) == str(len(claims))


def test_a_ratio_is_taken_seed_by_seed(store, claims):
    store.run("sip_basis", {"mae_tau": [1.0, 2.0]}, hidden="10")
    store.run("sip_basis", {"mae_tau": [2.0, 4.0]}, hidden="2x32")
    text = "{ratio sip_basis mae_tau hidden=10 over hidden=2x32}"
    assert filled(text, store, claims) == r"0.5 \[0.5, 0.5\]"


def test_loops_and_timings_are_counted(nothing, claims):
    control = [{"experiment": "sip_control", "setting": "sip", "success": done} for done in (True, False, True)]
    bench = [
        {"name": "lnn_best", "size": size, "ratio_median": ratio} for size, ratio in (("1x10", 2.0), ("2x32", 3.0))
    ]
    results = Results(**{name: typed(name, {"control": control, "bench": bench}.get(name, [])) for name in TABLES})
    text = (
        "{loops sip_control setting=sip}; {bench lnn_best}; {bench lnn_best size=1x10}; {loops sip_control setting=x}"
    )
    assert fill(text, results, judge_all(claims, results), "here") == "2 of 3; 2 to 3; 2; not run"


def test_guards_drop_sentences_items_and_paragraphs(nothing, claims):
    verdicts = judge_all(claims, nothing)
    text = """First.
{if C4a matched} Dropped
over two lines.
{if C4a not run or better, C5a not run} Kept.

- {if C4a better} dropped item
- {if C4a not run} kept item

{if C4a worse} Dropped paragraph.

Last."""
    assert fill(text, nothing, verdicts, "here") == "First.\nKept.\n\n- kept item\n\nLast."


@pytest.mark.parametrize(
    "text",
    ["{claim.C99}", "{claim.C4a.mean}", "{metric sip_basis}", "{nonsense}", "{if C4a true} x", "{loops a colour=red}"],
)
def test_a_mistake_in_a_text_is_an_error(text, nothing, claims):
    with pytest.raises(UserError, match="here"):
        fill(text, nothing, judge_all(claims, nothing), "here")


def test_a_section_without_its_head_is_an_error(tmp_path):
    (tmp_path / "01-lost.md").write_text("## Asked\n\nWhat?\n")
    with pytest.raises(UserError, match="must begin with title"):
        load_sections(tmp_path)
    head = "---\ntitle: A\nfigures: []\ntables: []\nclaims: []\n---\n"
    (tmp_path / "01-lost.md").write_text(f"{head}## Wondered\n\nWhat?\n")
    with pytest.raises(UserError, match=f"allowed: {', '.join(HEADINGS)}"):
        load_sections(tmp_path)
