import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.commands import report as command
from repro.errors import UserError
from repro.report import publish, readme
from repro.report.build import build, redraw
from repro.report.paper import load_figures, paper_folder
from repro.report.terminal import show
from repro.results.gather import gather
from repro.results.results import Results
from repro.tracking.paths import project_folder

ROOT = project_folder()
BLOCKS = ("count", "verdicts", "models", "trap")


def test_a_build_writes_results_tables_figures_and_the_pages(built):
    assert built.page.is_file()
    assert {path.name for path in built.results.glob("*")} == {
        *(f"{name}.parquet" for name in ("metrics", "runs", "curves", "trajectories", "bench", "identifiability")),
        "control.parquet",
        "closed_loops.parquet",
        "stages.parquet",
        "claims.csv",
        "sensitivity.csv",
        "sensitivity",
    }
    for figure in load_figures(paper_folder()):
        assert (built.figures / f"{figure.name}.pdf").read_bytes().startswith(b"%PDF")
        assert (built.figures / f"{figure.name}.png").read_bytes().startswith(b"\x89PNG")
    assert list(built.folder.rglob(".*")) == []


def test_an_unchanged_report_is_not_made_again_and_a_changed_one_is(quick_store):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    first = build(quick_store.outputs, "quick")
    stamp = first.page.stat().st_mtime_ns
    assert build(quick_store.outputs, "quick") == first
    assert first.page.stat().st_mtime_ns == stamp
    quick_store.run("sip_basis", {"mae_tau": [0.5, 0.6]}, basis="raw")
    assert build(quick_store.outputs, "quick").runs == 2
    assert first.page.stat().st_mtime_ns > stamp
    assert build(quick_store.outputs, "quick", stale=lambda record: True).stale == 2


def test_without_runs_the_error_says_what_there_is_and_how_to_start(store):
    store.run("sip_basis", {"mae_tau": [0.2]})
    with pytest.raises(UserError, match=r"nothing of scale quick.*run so far: paper.*make reproduce SCALE=quick"):
        build(store.outputs, "quick")


def test_everything_is_drawn_again_from_results_alone(built, tmp_path):
    again = redraw(built.results, tmp_path / "again")
    assert again.verdicts == built.verdicts
    for name in ("index.html", "claims/C4a.html", "tables/bases.csv", "results/claims.csv", "figures/regimes.png"):
        assert (again.folder / name).read_bytes() == (built.folder / name).read_bytes(), name


def test_the_terminal_shows_every_answered_claim_and_the_places(built, capsys):
    from rich.console import Console

    for width in (80, 160):
        show(built, Console(width=width))
        text = capsys.readouterr().out
        assert all(len(line) <= width for line in text.splitlines()[:-8])
        for line in built.verdicts:
            assert line.claim in text
        assert str(built.page) in text or "index.html" in text
        assert "a trivial, degenerate or oracle row does as well: " in text


def test_a_figure_without_data_is_left_out(quick_store):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    drawn = {path.stem for path in build(quick_store.outputs, "quick").folder.glob("figures/*")}
    assert drawn == {"framework", "plnn", "port_matrices"}  # of the models, whatever was run


def test_the_projects_assumptions_are_complete():
    ledger = {assumption.id for assumption in load_assumptions(ROOT / "paper" / "assumptions.yaml")}
    reasons = " ".join(claim.reason for claim in load_claims(ROOT / "paper" / "claims.yaml"))
    assert {"angle_convention", "energy_gauge", "fig4_metric", "gravity"} <= ledger
    assert all(word.strip("();,") in ledger for word in reasons.split("assumption ")[1:2] for word in word.split()[:1])


def test_an_incomplete_assumption_is_named(tmp_path):
    path = tmp_path / "assumptions.yaml"
    path.write_text("- {id: gravity, where: V}", encoding="utf-8")
    with pytest.raises(UserError, match=r"row 1 \(gravity\): quote is needed"):
        load_assumptions(path)


# ---- README ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def checkout(tmp_path) -> Path:
    """A git checkout of its own with claims, assumptions and a README that has the marks."""
    return make_checkout(tmp_path / "checkout")


@pytest.fixture(scope="module")
def published(tmp_path_factory, built) -> Path:
    root = make_checkout(tmp_path_factory.mktemp("published") / "checkout")
    publish.publish(Results.load(built.results), root)
    return root


def make_checkout(root: Path) -> Path:
    (root / "paper").mkdir(parents=True)
    for name in ("claims.yaml", "assumptions.yaml"):
        (root / "paper" / name).write_bytes((ROOT / "paper" / name).read_bytes())
    marks = "".join(f"<!-- {name}:begin -->\n<!-- {name}:end -->\n" for name in BLOCKS)
    (root / "README.md").write_text(f"# Title\n{marks}below\n", encoding="utf-8")
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
    assert readme.drift(published) == []
    text = (published / "README.md").read_text(encoding="utf-8")
    assert text.startswith("# Title\n<!-- count:begin -->\n**")
    assert text.endswith("<!-- trap:end -->\nbelow\n")
    assert "| C4a | PLNN" in text
    assert (published / "paper" / "tables" / "verdicts.csv").is_file()
    assert (published / "paper" / "figures" / "validation.pdf").is_file()
    assert (published / "paper" / "report.pdf").read_bytes().startswith(b"%PDF")


def test_drift_of_the_readme_and_of_the_claims_is_reported(published, tmp_path):
    root = tmp_path / "copy"
    shutil.copytree(published, root)
    page = root / "README.md"
    page.write_text(page.read_text(encoding="utf-8").replace("| matched", "| better", 1), encoding="utf-8")
    assert readme.drift(root) == ["README.md shows another table of verdicts than paper/results gives"]
    claims = root / "paper" / "claims.yaml"
    claims.write_text(claims.read_text(encoding="utf-8").replace("printed: 0.26", "printed: 26.0"), encoding="utf-8")
    assert "claims.csv holds another verdict of C4a than better" in readme.drift(root)
    assert any(line.startswith("sensitivity.csv holds another verdict of data_regime") for line in readme.drift(root))


def test_only_a_clean_tree_of_the_full_scale_and_the_present_code_is_published(checkout, built):
    results = Results.load(built.results)
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


def test_a_readme_without_marks_is_an_error(built, tmp_path):
    (tmp_path / "README.md").write_text("# Title\n", encoding="utf-8")
    with pytest.raises(UserError, match="lacks the marks"):
        readme.write_tables(tmp_path / "README.md", Results.load(built.results), [])


def test_the_committed_verdicts_have_not_drifted():
    if not (ROOT / "paper" / "results" / "metrics.parquet").is_file():
        pytest.skip("no results are committed yet")
    assert readme.drift(ROOT) == []


# ---- command ---------------------------------------------------------------------------------------------------------


def test_the_command_redraws_from_a_folder_of_results(quick_store, tmp_path, monkeypatch, capsys):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    gather(quick_store.outputs, "quick").save(tmp_path / "results")
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "elsewhere"))
    assert command.main(["--from", str(tmp_path / "results")]) == 0
    assert (tmp_path / "elsewhere" / "report" / "redrawn" / "index.html").is_file()
    assert "Verdicts, scale quick" in capsys.readouterr().out


def test_the_command_gathers_the_store(quick_store, monkeypatch, capsys):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    monkeypatch.setenv("REPRO_OUTPUTS", str(quick_store.outputs))
    assert command.main([]) == 0
    assert "1 runs" in capsys.readouterr().out


def test_the_command_refuses_a_folder_without_results(tmp_path, monkeypatch):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    with pytest.raises(UserError, match="holds no metrics"):
        command.main(["--from", str(tmp_path)])


def test_an_empty_result_is_still_judged(tmp_path):
    verdicts = judge_all(load_claims(ROOT / "paper" / "claims.yaml"), gather(tmp_path, "quick"))
    assert {verdict.verdict for verdict in verdicts} == {"not run", "not comparable", "under-specified"}
