"""Plain text for the terminal."""

import pytest

from repro.tracking.text import table, terminal_width

ROWS, HEADER = [["9f3c2a81bd", 0.26, "t2"], ["04be7d1f6a", 12.5, "t1"]], ["id", "mae_tau", "basis"]


def test_a_table_shows_every_column_where_no_width_is_given():
    assert table(ROWS, HEADER).splitlines() == [
        "id          mae_tau  basis",
        "9f3c2a81bd  0.26     t2",
        "04be7d1f6a  12.5     t1",
    ]


@pytest.mark.parametrize(("width", "shown"), [(26, 3), (25, 2), (19, 2), (18, 1), (3, 1)])
def test_a_table_shows_the_columns_that_fit_and_names_the_others(width, shown):
    head, *lines = table(ROWS, HEADER, width).splitlines()
    assert head.split() == HEADER[:shown]
    if shown < len(HEADER):
        assert lines[-1] == f"not shown, for lack of width: {', '.join(HEADER[shown:])}"


def test_what_is_no_terminal_has_no_width(capsys, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    assert terminal_width() is None
