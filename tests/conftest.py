"""Fixtures of several rooms: a fresh outputs folder, processes that use it, and stores of synthetic runs."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

# As in a sweep's jobs: equal bits, and small problems run faster. Read when torch and numpy are loaded.
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

from repro.tracking import code

if TYPE_CHECKING:
    from synthetic_store import SyntheticStore


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
