"""Fixtures of several rooms: a fresh outputs folder, processes that use it, and stores of synthetic runs."""

from __future__ import annotations

import gc
import multiprocessing
import os
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from compilation import unoptimised

# As in a sweep's jobs: equal bits, and small problems run faster. Read when torch and numpy are loaded.
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
# Threads that wait for another one leave the processor to the tests beside them.
os.environ["OMP_WAIT_POLICY"] = "passive"
# The suite starts some hundred interpreters: without stored bytecode each of them would compile the project again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from repro.tracking import code

if TYPE_CHECKING:
    from synthetic_store import SyntheticStore

sys.dont_write_bytecode = False
gc.disable()  # until all tests are collected: what is imported stays

# What the jobs of any test need and takes long to load.
HEAVY = ("repro.pipeline.run", "repro.learning.optimisers.adam", "repro.recording.layout", "rerun.blueprint")
HEAVY += ("pyarrow.dataset",)
HEAVY += ("torch", "repro.report.drawing", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf")


def pytest_collection_finish() -> None:
    gc.freeze()  # Python's search for unused objects leaves out the libraries and the list of tests
    gc.set_threshold(50_000, 20)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def _cheaper() -> Iterator[None]:
    """What costs a test process time and is no part of any check."""
    preload = multiprocessing.set_forkserver_preload

    def preload_for_all(modules: list[str]) -> None:
        # The first sweep or report starts the one server of this process; the jobs of all others come from it too.
        *others, last = modules
        preload([*dict.fromkeys([*others, *HEAVY]), last])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(multiprocessing, "set_forkserver_preload", preload_for_all)
        patch.setattr(
            os, "fsync", lambda descriptor: None
        )  # results in a temporary folder need not outlive the machine
        yield


@pytest.fixture(scope="module", name="unoptimised")
def _unoptimised() -> Iterator[None]:
    """For tests of small problems whose numbers follow from the source alone: see `unoptimised`."""
    with unoptimised():
        yield


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    folder = tmp_path / "outputs"
    monkeypatch.setenv("REPRO_OUTPUTS", str(folder))
    code.closure.cache_clear()
    yield folder
    code.closure.cache_clear()


@pytest.fixture
def start(tmp_path: Path, root: Path) -> Callable[..., subprocess.Popen[str]]:
    """start(code, jobs=...): a Python process that can import the text `jobs` as the module toyjobs."""

    def run(program: str, jobs: str = "") -> subprocess.Popen[str]:
        module = tmp_path / "toyjobs.py"
        if not module.exists():
            module.write_text(textwrap.dedent(jobs))
        return subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(program)],
            env={
                **os.environ,
                "PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
                "REPRO_OUTPUTS": str(root),
            },
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    return run


@pytest.fixture
def store(tmp_path: Path) -> SyntheticStore:
    """An empty store of runs at the scale of the paper."""
    from synthetic_store import SyntheticStore  # loads pandas

    return SyntheticStore(tmp_path / "outputs", "paper")


@pytest.fixture
def quick_store(tmp_path: Path) -> SyntheticStore:
    """An empty store of runs at the quick scale."""
    from synthetic_store import SyntheticStore

    return SyntheticStore(tmp_path / "outputs", "quick")
