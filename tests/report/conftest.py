"""The report of synthetic runs of every experiment."""

import pytest
from synthetic_runs import fill
from synthetic_store import SyntheticStore

from repro.report.build import build
from repro.report.summary import Summary
from repro.results.results import Results


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Summary:
    """The report of every experiment."""
    store = SyntheticStore(tmp_path_factory.mktemp("built") / "outputs", "paper")
    fill(store)
    return build(store.outputs, "paper")


@pytest.fixture(scope="session")
def results(built: Summary) -> Results:
    """The results behind that report."""
    return Results.load(built.results)
