"""Control in the report: tables, figures and animations from stored closed loops."""

import pytest
from synthetic_loops import EXPERIMENT, loop, moving, results

from repro.report.animation import animate_all
from repro.report.paper import load_animations, load_figures, paper_folder
from repro.report.tables.closed_loops import LoopTable
from repro.results.stored_loop import find_loop


def test_a_table_has_a_row_for_whatever_differs():
    loops = [loop(k, k != 0) for k in range(4)] + [loop(k, False, mismatch=0.1, contact=True) for k in range(2)]
    table = LoopTable("loops", "t", EXPERIMENT, "T").make(results(loops))
    assert [row.data["mismatch"] for row in table.rows] == ["0", "0.1"]
    first, second = (row.data for row in table.rows)
    assert (first["loops"], first["success"], second["success"], second["contacts"]) == (4, 0.75, 0.0, 2)
    assert second["held_from_s"] is None and first["solve_ms_median"] == 11.5
    assert [first[f"fallbacks_{level}"] for level in (1, 2, 3)] == [3, 2, 1]
    assert "delay" not in first, "what is the same everywhere is not a column"


def test_a_stored_loop_is_found_by_the_first_choice_that_was_run():
    stored = results([loop(0, True)], moving())
    found = find_loop(stored, EXPERIMENT, ({"model": "structured"}, {"model": "truth", "intervals": 20}))
    assert found.series["theta"].shape == (51,) and found.obstacle == (0.0, 0.6, 0.3)
    assert found.settings["system.name"] == "sip"
    assert found.angles == ["theta"] and found.time[found.settled] == pytest.approx(1.0)
    assert find_loop(stored, EXPERIMENT, ({"model": "structured"},)) is None


def test_figures_and_animations_are_written_where_there_is_something_to_show(tmp_path, monkeypatch):
    monkeypatch.setattr("repro.report.animation.FRAME", 0.4)  # few frames
    stored = results([loop(k, k > 0) for k in range(3)], moving())
    figures = {figure.name: figure for figure in load_figures(paper_folder())}
    animations = load_animations(paper_folder())
    assert figures["sip_closed_loop"].save(stored, tmp_path) and figures["success_map"].save(stored, tmp_path)
    assert not figures["dip_closed_loop"].save(stored, tmp_path)
    (path,) = animate_all(stored, animations, tmp_path)
    assert path.name == "sip_swing_up.gif" and path.read_bytes()[:6] == b"GIF89a"
    assert animate_all(results([]), animations, tmp_path) == []
