"""Code of the documentation: examples in docstrings, and the blocks of docs/library.md."""

import doctest
import re
import runpy
from importlib import import_module
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
BLOCKS = {
    f"{page}, block {number}": text
    for page in ("library.md", "from-other-packages.md")
    for number, text in enumerate(
        re.findall(r"^```python\n(.*?)^```$", (DOCS / page).read_text(), re.MULTILINE | re.DOTALL), start=1
    )
}
HOOK = DOCS / "hooks" / "notebooks.py"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.py"))
MODULES = ["repro", *(f"repro.library.{name}" for name in ("choices", "datasets", "fitting", "ensemble_model"))]


@pytest.mark.parametrize("module", MODULES)
def test_examples_in_docstrings(module):
    result = doctest.testmod(import_module(module))
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.slow
@pytest.mark.parametrize("block", BLOCKS)
def test_blocks_of_the_pages(block, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS[block], block, "exec"), {"__name__": "__main__"})


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run_and_show_something_in_every_cell(path):
    page = runpy.run_path(str(HOOK))["page"](path)
    assert page.count("```python") == len(re.findall(r"^# %%$", path.read_text(), re.MULTILINE))
    assert "![what the cell draws](data:image/png" in page or "<table" in page
