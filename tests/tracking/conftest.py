"""A small package that a test may edit, and a store in a fresh folder."""

from __future__ import annotations

import importlib
import itertools
import os
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from repro.tracking import code
from repro.tracking.cache import Cache
from repro.tracking.stage import Stage
from repro.tracking.store import Store

_numbers = itertools.count()

FILES = {
    "__init__.py": '"""Lazy exports."""\ndef __getattr__(name):\n    from {name}.tracking import load\n',
    "errors.py": "class UserError(Exception): pass\n",
    "tracking/__init__.py": "",
    "tracking/load.py": "import pandas\n",
    "data/__init__.py": "",
    "data/make.py": """
        '''Data.'''
        import numpy as np
        from {name}.errors import UserError

        def make(samples=100):
            return samples
        """,
    "learning/__init__.py": "",
    "learning/kernel.c": "/* a kernel */\nint kernel(void) { return 1; }\n",
    "learning/loss.py": "def loss(error):\n    return error**2\n",
    "learning/fit.py": """
        from typing import TYPE_CHECKING
        from {name}.tracking import load
        from . import loss
        if TYPE_CHECKING:
            from {name}.report.figure import draw

        def fit():
            from {name}.data import make
            import yaml
            return loss.loss(make.make())
        """,
    "evaluation/__init__.py": "",
    "evaluation/score.py": "from {name}.learning import fit\n",
    "report/__init__.py": "",
    "report/figure.py": "# how it looks\nimport {name}.evaluation.score\ndef draw(): return 1\n",
}


class Toy:
    """A package on disk with data, learning, evaluation and report."""

    def __init__(self, folder: Path) -> None:
        self.name = f"toy{next(_numbers)}_{os.getpid()}"
        self.folder = folder / self.name
        for name, text in FILES.items():
            self.write(name, textwrap.dedent(text).replace("{name}", self.name))

    def write(self, name: str, text: str) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        code.closure.cache_clear()

    def edit(self, name: str, old: str, new: str) -> None:
        text = (self.folder / name).read_text()
        assert old in text
        self.write(name, text.replace(old, new))

    def stages(self, samples: int = 100, epochs: int = 10) -> dict[str, Stage]:
        """A run as data -> fit -> score -> figure."""
        data = Stage("data", "toy data", {"samples": samples}, {}, (f"{self.name}.data.make",))
        fit = Stage("fits", "toy fit", {"epochs": epochs}, {"data": data.id}, (f"{self.name}.learning.fit",))
        score = Stage("runs", "toy", {}, {"fit": fit.id}, (f"{self.name}.evaluation.score",))
        figure = Stage("figures", "toy figure", {}, {"run": score.id}, (f"{self.name}.report.figure",))
        return {"data": data, "fit": fit, "score": score, "figure": figure}

    def ids(self, **settings: int) -> dict[str, str]:
        return {role: stage.id for role, stage in self.stages(**settings).items()}


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Toy:
    package = Toy(tmp_path / "source")
    monkeypatch.setattr(code.READER, "cache", Cache(tmp_path / "code.sqlite", 0))
    monkeypatch.syspath_prepend(tmp_path / "source")
    importlib.invalidate_caches()
    return package


@pytest.fixture
def store(root: Path) -> Store:
    return Store(root)


@pytest.fixture
def stage(toy: Toy) -> Callable[..., Stage]:
    """stage(**config): a small stage of kind fits."""
    return lambda **config: Stage("fits", "toy fit", config, {}, (f"{toy.name}.data.make",), command="repro run toy")
