"""The report of synthetic runs of every experiment."""

import os
from collections.abc import Iterator
from dataclasses import fields, replace

import pandas as pd
import pytest
from filelock import FileLock
from synthetic_runs import fill
from synthetic_store import PAPER, SyntheticStore

from repro.report.build import build
from repro.report.paper import load_figures, paper_folder
from repro.report.summary import Summary
from repro.results.gather import Gathering
from repro.results.results import Results


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Summary:
    """The report of every experiment; processes that test side by side make it once."""
    folder = tmp_path_factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    with FileLock(folder / "report.lock"):
        store = SyntheticStore(folder / "report" / "outputs", "paper")
        if not store.outputs.exists():
            fill(store)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Gathering, "load", lambda _folder: PAPER)
            return build(store.outputs, "paper")


@pytest.fixture(scope="session")
def results(built: Summary) -> Results:
    """The results behind that report."""
    return Results.load(built.results)


@pytest.fixture(scope="session")
def few_results(results: Results) -> Results:
    """Those of two experiments, which are drawn and written in a moment."""

    def some(table: pd.DataFrame) -> pd.DataFrame:
        return table[table["experiment"].isin(["sip_basis", "sip_regimes"])] if "experiment" in table else table

    tables = {one.name: getattr(results, one.name) for one in fields(results)}
    return replace(results, **{name: some(t) for name, t in tables.items() if isinstance(t, pd.DataFrame)})


@pytest.fixture
def pages_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """A report without figures and PDF."""
    monkeypatch.setattr("repro.report.build.start_server", lambda modules: None)
    monkeypatch.setattr("repro.report.build.draw_all", lambda *arguments: [])
    monkeypatch.setattr("repro.report.build.write_pdf", lambda *arguments: None)


@pytest.fixture(scope="module")
def two_figures() -> Iterator[None]:
    """A report with two figures."""
    with pytest.MonkeyPatch.context() as patch:
        some = [figure for figure in load_figures(paper_folder()) if figure.name in ("validation", "regimes")]
        patch.setattr("repro.report.drawing.load_figures", lambda _folder: some)
        yield
