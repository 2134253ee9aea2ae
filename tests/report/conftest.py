"""The report of synthetic runs of every experiment."""

from collections.abc import Callable
from pathlib import Path

import pytest
from synthetic_runs import fill
from synthetic_store import SyntheticStore

from repro.report.build import build
from repro.report.summary import Summary


@pytest.fixture(scope="session")
def synthetic() -> Callable[..., SyntheticStore]:
    def make(outputs: Path, *, full: bool = False) -> SyntheticStore:
        made = SyntheticStore(outputs, "paper")
        if full:
            fill(made)
        return made

    return make


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory, synthetic: Callable[..., SyntheticStore]) -> Summary:
    """The report of every experiment."""
    return build(synthetic(tmp_path_factory.mktemp("built") / "outputs", full=True).outputs, "paper")
