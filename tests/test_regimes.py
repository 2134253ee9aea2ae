"""The tables of docs/related-work.md are those of the published results, by docs/regimes.py."""

import runpy
import sys
from itertools import groupby
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "docs" / "regimes.py"
REGIMES = runpy.run_path(str(SCRIPT))


def error_tables():
    """Each table of errors: its columns, each with the cells of all methods that it has."""
    lines = REGIMES["PAGE"].read_text(encoding="utf-8").split("regimes -->")[1].splitlines()
    for filled, group in groupby(lines, key=bool):
        rows = [line.strip("|").split("|") for line in group]
        if filled and any("of ours" in row[0] for row in rows):
            methods = [
                row
                for row in rows[2:]
                if row[0].strip() not in {*REGIMES["ANCHORS"], "*best network of a peer / of ours*"}
            ]
            yield rows[0][0].strip(), [[cell.strip() for cell in column] for column in zip(*methods, strict=True)][1:]


def test_the_published_tables_are_up_to_date():
    """Otherwise run `python docs/regimes.py`."""
    assert REGIMES["main"](["--check"]) == 0, f"run `{Path(sys.executable).name} docs/regimes.py`"


@pytest.mark.parametrize(("title", "columns"), list(error_tables()))
def test_the_smallest_error_of_a_column_is_in_bold(title, columns):
    for column in columns:
        errors = {cell: float(cell.strip("*†").replace("∞", "inf")) for cell in column if cell != REGIMES["ABSENT"]}
        assert all(("**" in cell) == (error == min(errors.values())) for cell, error in errors.items()), title
