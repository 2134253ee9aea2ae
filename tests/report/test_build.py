"""From stored runs to the report, and the command that makes it."""

import pytest

from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.commands import report as command
from repro.commands.arguments import parsed
from repro.errors import UserError
from repro.report.build import build
from repro.report.paper import load_figures, paper_folder
from repro.report.terminal import show
from repro.results.gather import gather
from repro.results.stored import read_stored
from repro.tracking.files import file_digest
from repro.tracking.paths import project_folder

ROOT = project_folder()


def test_a_build_writes_results_tables_figures_and_the_pages(built):
    assert built.page.is_file()
    assert {path.name for path in built.results.glob("*")} == {
        *(f"{name}.parquet" for name in ("metrics", "runs", "curves", "trajectories", "bench", "identifiability")),
        "control.parquet",
        "closed_loops.parquet",
        "cases.parquet",
        "stages.parquet",
        "claims.csv",
        "sensitivity.csv",
        "sensitivity",
    }
    for figure in load_figures(paper_folder()):
        assert (built.folder / "figures" / f"{figure.name}.pdf").read_bytes().startswith(b"%PDF")
        assert (built.folder / "figures" / f"{figure.name}.png").read_bytes().startswith(b"\x89PNG")
    assert list(built.folder.rglob(".*")) == []


@pytest.mark.usefixtures("pages_only")
def test_an_unchanged_report_is_not_made_again_and_a_changed_one_is_without_pages_of_the_former(quick_store):
    one = quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    first = build(quick_store.outputs, "quick")
    left = first.folder / "runs" / "sip-other-0000000000.html"
    left.write_text("", encoding="utf-8")
    stamp = first.page.stat().st_mtime_ns
    assert build(quick_store.outputs, "quick") == first
    assert first.page.stat().st_mtime_ns == stamp
    other = quick_store.run("sip_basis", {"mae_tau": [0.5, 0.6]}, basis="raw")
    assert build(quick_store.outputs, "quick").runs == 2
    assert first.page.stat().st_mtime_ns > stamp
    assert {path.stem for path in left.parent.iterdir()} == {one, other}
    assert build(quick_store.outputs, "quick", stale={one, other}).stale == 2


@pytest.mark.usefixtures("pages_only")
def test_a_finished_run_that_was_listed_before_it_was_made_is_no_change(quick_store):
    run = quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    made = build(quick_store.outputs, "quick")
    (job,) = quick_store.jobs["sip_basis"]
    assert job["run"] == run
    job |= {"settings": {"basis.name": "t2"}, "changed": ["basis.name"]}
    quick_store.list_job("sip_basis", quick_store.jobs["sip_basis"].pop())
    assert build(quick_store.outputs, "quick") == made


@pytest.mark.usefixtures("pages_only")
def test_other_code_that_gathers_judges_or_draws_makes_the_report_again(quick_store, monkeypatch):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    made = build(quick_store.outputs, "quick")
    assert made.fingerprint == build(quick_store.outputs, "quick").fingerprint
    for room in ("claims", "report", "results"):
        changed = next((ROOT / "src" / "repro" / room).glob("[a-z]*.py"))

        def digest_of(path, changed=changed):
            return "" if path == changed else file_digest(path)

        with monkeypatch.context() as patch:
            patch.setattr("repro.report.build.file_digest", digest_of)
            assert made.fingerprint != build(quick_store.outputs, "quick").fingerprint


def test_without_runs_the_error_says_what_there_is_and_how_to_start(store):
    store.run("sip_basis", {"mae_tau": [0.2]})
    with pytest.raises(UserError, match=r"no experiment of scale quick.*run so far: scale paper.*repro reproduce$"):
        build(store.outputs, "quick")


def test_the_terminal_shows_every_answered_claim_and_the_places(built, capsys):
    from rich.cells import cell_len
    from rich.console import Console

    for width in (80, 160):
        show(built, Console(width=width))
        text = capsys.readouterr().out
        assert all(cell_len(line) <= width for line in text.splitlines()[:-8])
        for line in built.verdicts:
            assert line["claim"] in text
        assert str(built.page) in text or "index.html" in text
        assert "a trivial, degenerate or oracle row satisfies it too: " in text


def test_the_projects_assumptions_are_complete():
    ledger = {assumption.id for assumption in load_assumptions(ROOT / "paper" / "assumptions.yaml")}
    reasons = " ".join(claim.reason for claim in load_claims(ROOT / "paper" / "claims.yaml"))
    assert {"angle_convention", "energy_gauge", "fig4_metric", "gravity"} <= ledger
    assert all(word.strip("();,") in ledger for word in reasons.split("assumption ")[1:2] for word in word.split()[:1])


def test_an_incomplete_assumption_is_named(tmp_path):
    path = tmp_path / "assumptions.yaml"
    path.write_text("- {id: gravity, where: V}", encoding="utf-8")
    with pytest.raises(UserError, match=r"row 1 \(gravity\): quote: a value is needed"):
        load_assumptions(path)


@pytest.mark.usefixtures("pages_only")
def test_the_command_redraws_from_a_folder_of_results(quick_store, tmp_path, monkeypatch, capsys):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    quick_store.gathered().save(tmp_path / "results")
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "elsewhere"))
    assert command.main(parsed("report", ["--from", str(tmp_path / "results")])) == 0
    assert (tmp_path / "elsewhere" / "report" / "redrawn" / "index.html").is_file()
    assert "Verdicts, scale quick" in capsys.readouterr().out


@pytest.mark.usefixtures("pages_only")
def test_the_command_gathers_the_store(quick_store, monkeypatch, capsys):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    monkeypatch.setenv("REPRO_OUTPUTS", str(quick_store.outputs))
    assert command.main(parsed("report", [])) == 0
    assert "1 runs" in capsys.readouterr().out


def test_the_command_refuses_a_folder_without_results(tmp_path, monkeypatch):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    with pytest.raises(UserError, match="holds no metrics"):
        command.main(parsed("report", ["--from", str(tmp_path)]))


def test_an_empty_result_is_still_judged(tmp_path):
    verdicts = judge_all(load_claims(ROOT / "paper" / "claims.yaml"), gather(read_stored(tmp_path, "quick")))
    assert {verdict.verdict for verdict in verdicts} == {
        "not run",
        "not comparable",
        "under-specified",
        "uninformative",
    }
