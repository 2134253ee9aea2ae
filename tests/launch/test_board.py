"""The board counts, estimates the time left, and stays readable without a terminal."""

from __future__ import annotations

import pytest

from repro.launch import board
from repro.launch.board import Board
from repro.launch.jobs import Event, EventKind, Job, JobOutcome, JobResult
from repro.tracking.text import duration, table

JOBS = [Job(name, "m:f") for name in ("a", "b", "c", "d")]


@pytest.fixture
def now(monkeypatch):
    """A clock that a test sets."""
    time = [0.0]
    monkeypatch.setattr(board.time, "monotonic", lambda: time[0])
    return time


def ended(index, outcome=JobOutcome.OK, seconds=10.0, error=""):
    result = JobResult(JOBS[index], outcome, seconds=seconds, error=error)
    return Event(EventKind.ENDED, index, result=result)


def test_the_time_left_is_what_the_pace_so_far_gives(now):
    shown = Board(JOBS, workers=2, live=False)
    assert shown.seconds_left() is None
    for index in (0, 1):
        shown(Event(EventKind.STARTED, index))
    now[0] = 5.0
    shown(Event(EventKind.PROGRESS, 0, fraction=0.25))
    shown(Event(EventKind.PROGRESS, 1, fraction=0.25))
    # Half a job in 5 s, by two workers: three and a half are left.
    assert shown.seconds_left() == pytest.approx(3.5 * 5 / 0.5)
    now[0] = 20.0
    for index in (0, 1):
        shown(ended(index, seconds=20.0))
    assert shown.seconds_left() == pytest.approx(20.0)


def test_a_longer_job_counts_for_more_and_expected_times_hold_before_any_progress(now):
    shown = Board([Job("a", "m:f", expected_s=30.0), Job("b", "m:f", expected_s=10.0)], workers=1, live=False)
    assert shown.seconds_left() == pytest.approx(40.0)
    now[0] = 60.0  # twice as slow as expected
    shown(ended(0, seconds=60.0))
    assert shown.seconds_left() == pytest.approx(20.0)


def test_plain_lines(now, capsys):
    with Board(JOBS, workers=1, live=False) as shown:
        shown(Event(EventKind.STARTED, 0))
        now[0] = 10.0
        shown(ended(0))
        shown(Event(EventKind.NOTICE, 1, text="look"))
        now[0] = 20.0
        shown(ended(1, JobOutcome.FAILED, 2.0, "ValueError: no\nmore"))
        now[0] = 60.0
        shown(Event(EventKind.STARTED, 2))
        shown(Event(EventKind.PROGRESS, 2, fraction=0.5, text="epoch 3"))
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "[1/4] a: done (10 s); about 30 s left"
    assert lines[1] == "b: look"
    assert lines[2] == "[2/4] b: failed: ValueError: no (2.0 s); about 20 s left"
    assert lines[3].startswith("2 of 4 done, 1 failed")
    assert lines[3].endswith("now c 50% epoch 3")


def test_live_display_takes_every_event(now, capsys):
    with Board(JOBS, workers=2, live=True) as shown:
        for index in (0, 1):
            shown(Event(EventKind.STARTED, index))
            shown(Event(EventKind.PROGRESS, index, fraction=0.5, text="[half]"))
        shown(ended(0))
        shown(ended(1, JobOutcome.KILLED, 1.0, "[SIGKILL]"))
    assert "b: killed: [SIGKILL]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.04, "0.0 s"), (9.94, "9.9 s"), (59.4, "59 s"), (200, "3 min 20 s"), (7500, "2 h 5 min")]
)
def test_durations(seconds, text):
    assert duration(seconds) == text


def test_tables():
    assert table([["a", 1], ["bcd", 22]], ["x", "y"]) == "x    y\na    1\nbcd  22"
    assert table([]) == ""
