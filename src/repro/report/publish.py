"""What is committed: results, tables, figures, the report and the README's tables, of full scale and a clean tree."""

import shutil
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

from repro.claims.verdicts import FULL_SCALE
from repro.errors import UserError
from repro.report.animation import animate_all
from repro.report.build import render
from repro.report.paper import load_animations, paper_folder
from repro.report.readme import write_tables
from repro.results.results import Results


def publish(results: Results, root: Path) -> None:
    """Write paper/results, tables, figures, animations, report.pdf, the tables of README.md and docs, in a checkout.

    Raises UserError for another scale, an unclean git tree or results older than the code.
    """
    if results.scale != FULL_SCALE:
        message = (
            f"only results of scale {FULL_SCALE} are published, these are of scale {results.scale or 'unknown'}; "
            f"run: make reproduce SCALE={FULL_SCALE}"
        )
        raise UserError(message)
    _refuse_unclean(root)
    _refuse_stale(results, f"make reproduce SCALE={FULL_SCALE}")
    committed = root / "paper" / "results"
    if results.sensitivity is not None:
        _refuse_stale(results.sensitivity, "repro sensitivity")
    elif committed.is_dir():
        results = replace(results, sensitivity=Results.load(committed).sensitivity)
    results.save(committed)
    with tempfile.TemporaryDirectory() as temporary:
        verdicts = render(results, Path(temporary))
        for computed in (Path(temporary) / "results").glob("*.csv"):
            shutil.copyfile(computed, committed / computed.name)
        shutil.copyfile(Path(temporary) / "report.pdf", root / "paper" / "report.pdf")
        for name in ("tables", "figures"):
            shutil.rmtree(root / "paper" / name, ignore_errors=True)
            shutil.copytree(Path(temporary) / name, root / "paper" / name)
    animate_all(results, load_animations(paper_folder()), root / "paper" / "animations")
    write_tables(root, results, verdicts)


def _refuse_stale(results: Results, command: str) -> None:
    stale = results.runs.loc[results.runs["stale"].fillna(value=False), "run"]
    if len(stale):
        raise UserError(f"{stale.nunique()} runs are older than the code; run: {command}")


def _refuse_unclean(root: Path) -> None:
    try:
        status = subprocess.run(
            ["git", "-C", str(root), "status", "--porcelain"], check=True, capture_output=True, text=True
        ).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        message = f"{root} is no git checkout, or git is not installed: only a clean tree is published"
        raise UserError(message) from error
    if status.strip():
        changed = ", ".join(line[3:] for line in status.splitlines()[:3])
        raise UserError(f"the git tree is not clean ({changed}, ...): commit or remove the changes, then publish")
