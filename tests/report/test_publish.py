"""What is published: results, tables, figures and the tables of README.md, which must not drift from the results."""

import csv
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from report_drift import drift

from repro.claims.claims import load_claims
from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import judge_all
from repro.errors import UserError
from repro.report import publish, readme
from repro.report.build import redraw
from repro.tracking.paths import project_folder

ROOT = project_folder()
BLOCKS = {
    "README.md": ("count", "headlines"),
    "docs/verdicts.md": ("verdicts",),
    "docs/better-models.md": ("models", "trap"),
}


@pytest.fixture
def checkout(tmp_path) -> Path:
    """A git checkout of its own with claims, assumptions and a README that has the marks."""
    return make_checkout(tmp_path / "checkout")


@pytest.fixture(scope="module")
def published(tmp_path_factory, few_results, two_figures) -> Path:
    root = make_checkout(tmp_path_factory.mktemp("published") / "checkout")
    publish.publish(few_results, root)
    return root


def make_checkout(root: Path) -> Path:
    (root / "paper").mkdir(parents=True)
    for name in ("claims.yaml", "assumptions.yaml"):
        (root / "paper" / name).write_bytes((ROOT / "paper" / name).read_bytes())
    (root / "docs").mkdir()
    for page, blocks in BLOCKS.items():
        marks = "".join(f"<!-- {name}:begin -->\n<!-- {name}:end -->\n" for name in blocks)
        (root / page).write_text(f"# Title\n{marks}below\n", encoding="utf-8")
    git(root, "init", "-q")
    commit(root)
    return root


def git(root: Path, *arguments: str) -> None:
    identity = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", "-C", str(root), *identity, *arguments], check=True, capture_output=True)


def commit(root: Path) -> None:
    git(root, "add", ".")
    git(root, "commit", "-qm", "all")


def test_publishing_writes_what_the_drift_check_accepts(published):
    assert drift(published) == []
    text = (published / "README.md").read_text(encoding="utf-8")
    assert text.startswith("# Title\n<!-- count:begin -->\n**")
    assert text.endswith("<!-- headlines:end -->\nbelow\n") and len(text.splitlines()) == 1 + 3 + 2 + 12 + 1
    assert "| C4a | PLNN" in text
    assert "| C4a | V-A.2 | PLNN" in (published / "docs" / "verdicts.md").read_text(encoding="utf-8")
    assert (published / "paper" / "tables" / "verdicts.csv").is_file()
    assert (published / "paper" / "figures" / "validation.pdf").is_file()
    assert (published / "paper" / "report.pdf").read_bytes().startswith(b"%PDF")


def test_drift_of_the_readme_and_of_the_claims_is_reported(published, tmp_path):
    root = tmp_path / "copy"
    shutil.copytree(published, root)
    page = root / "docs" / "verdicts.md"
    page.write_text(page.read_text(encoding="utf-8").replace("| consistent", "| outside", 1), encoding="utf-8")
    assert drift(root) == ["docs/verdicts.md shows another table of verdicts than paper/results gives"]
    claims = root / "paper" / "claims.yaml"
    claims.write_text(claims.read_text(encoding="utf-8").replace("printed: 0.26", "printed: 26.0"), encoding="utf-8")
    found = drift(root)
    assert "claims.csv holds another verdict of C4a than outside" in found
    assert any(line.startswith("sensitivity.csv holds another leaning of data_regime") for line in found)


def test_only_a_clean_tree_of_the_full_scale_and_the_present_code_is_published(checkout, results):
    (checkout / "stray.txt").write_text("x", encoding="utf-8")
    with pytest.raises(UserError, match=r"not clean \(stray.txt"):
        publish.publish(results, checkout)
    commit(checkout)
    runs = results.runs.assign(stale=pd.array([True] + [False] * (len(results.runs) - 1), dtype="boolean"))
    stale = replace(results, runs=runs)
    with pytest.raises(UserError, match="1 runs are older than the code"):
        publish.publish(stale, checkout)
    quick = replace(results, runs=results.runs.assign(scale="quick"))
    with pytest.raises(UserError, match="only results of scale paper are published, these are of scale quick"):
        publish.publish(quick, checkout)


def test_a_readme_without_marks_is_an_error(results, tmp_path):
    (tmp_path / "README.md").write_text("# Title\n", encoding="utf-8")
    with pytest.raises(UserError, match="lacks the marks"):
        readme.write_tables(tmp_path, results, judge_all(load_claims(ROOT / "paper" / "claims.yaml"), results))


def test_the_committed_verdicts_have_not_drifted():
    if not (ROOT / "paper" / "results" / "metrics.parquet").is_file():
        pytest.skip("no results are committed yet")
    assert drift(ROOT) == []


def test_a_no_names_the_smallest_change_that_makes_it_hold_or_what_was_tried():
    with (ROOT / "paper" / "results" / "claims.csv").open(encoding="utf-8", newline="") as rows:
        verdicts = {row["id"]: row for row in csv.DictReader(rows)}
    assert len(verdicts) > 50
    negative = {VerdictKind.NOT_SUPPORTED, VerdictKind.OUTSIDE}
    noes = {name: row for name, row in verdicts.items() if {row["verdict"], row["leaning"]} & negative}
    assert [name for name, row in noes.items() if not row["cure"]] == []
    tried = [row["cure"] for row in noes.values() if not row["cure_runs"]]
    assert all(cure.startswith("none found among ") or cure.endswith(": not run") for cure in tried)


def test_everything_is_drawn_again_from_the_published_results_alone(published, tmp_path):
    paper = published / "paper"
    again = redraw(paper / "results", tmp_path / "again").folder
    for name in ("tables/bases.csv", "results/claims.csv", "figures/regimes.png", "figures/regimes.pdf", "report.pdf"):
        assert (again / name).read_bytes() == (paper / name).read_bytes(), name
    assert (again / "claims" / "C4a.html").is_file()
