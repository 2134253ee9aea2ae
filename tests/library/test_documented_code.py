"""Code of the documentation: examples in docstrings, and the blocks of docs/library.md."""

import doctest
import re
import runpy
from importlib import import_module
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "library.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
HOOK = PAGE.parent / "hooks" / "notebooks.py"
NOTEBOOKS = sorted((PAGE.parent / "notebooks").glob("*.py"))
MODULES = ["repro", *(f"repro.library.{name}" for name in ("choices", "datasets", "fitting", "ensemble_model"))]


@pytest.mark.parametrize("module", MODULES)
def test_examples_in_docstrings(module):
    result = doctest.testmod(import_module(module))
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_blocks_of_the_page(number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS[number], f"{PAGE.name}, block {number + 1}", "exec"), {"__name__": "__main__"})


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run_and_show_something_in_every_cell(path):
    page = runpy.run_path(str(HOOK))["page"](path)
    assert page.count("```python") == len(re.findall(r"^# %%$", path.read_text(), re.MULTILINE))
    assert "![what the cell draws](data:image/png" in page or "<table" in page
