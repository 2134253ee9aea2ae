"""The simulated schedule of docs/scaling.py, and the numbers that it writes into docs/scale-out.md."""

import math
import runpy
import sys
from pathlib import Path

import pandas as pd
import pytest

SCRIPT = Path(__file__).parents[1] / "docs" / "scaling.py"
SCALING = runpy.run_path(str(SCRIPT))
Job, Stage, simulated = SCALING["Job"], SCALING["Stage"], SCALING["simulated"]


def jobs(*stages: list[tuple[str, float]], mib: float = 100.0):
    return [Job([Stage(*stage) for stage in of_job], mib) for of_job in stages]


def alone(*seconds: float, mib: float = 100.0):
    return jobs(*([(f"s{number}", each)] for number, each in enumerate(seconds)), mib=mib)


@pytest.mark.parametrize(("cores", "seconds"), [(1, 20.0), (2, 10.0), (4, 7.0), (64, 7.0)])
def test_the_longest_job_starts_first(cores, seconds):
    """In the given order two cores would take 12 s: the job of 7 s comes last."""
    assert simulated(alone(2, 4, 1, 2, 4, 7), cores, math.inf).seconds == seconds


@pytest.mark.parametrize("cores", [1, 2, 3, 8])
def test_a_schedule_lies_between_the_bounds_of_any_list(cores):
    """At least the mean load and the longest job; at most the mean load and a share of the longest (Graham 1966)."""
    costs = [3.0, 3.0, 2.0, 2.0, 2.0, 5.0, 1.0, 4.0]
    load, longest = sum(costs) / cores, max(costs)
    assert max(load, longest) <= simulated(alone(*costs), cores, math.inf).seconds <= load + (1 - 1 / cores) * longest


def test_stages_of_a_job_follow_one_another_and_a_shared_one_is_made_once():
    both = jobs([("data", 2.0), ("a", 3.0), ("a'", 1.0)], [("data", 2.0), ("b", 1.0)])
    assert simulated(both, 1, math.inf).seconds == 7.0
    assert simulated(both, 2, math.inf).seconds == 6.0
    ahead = jobs([("long", 9.0)], [("long", 9.0), ("short", 1.0)])
    assert simulated(ahead, 2, math.inf).seconds == 10.0


@pytest.mark.parametrize(("memory", "seconds", "peak"), [(300.0, 2.0, 300.0), (250.0, 4.0, 200.0), (10.0, 6.0, 100.0)])
def test_jobs_wait_for_memory_and_one_is_started_whatever_it_takes(memory, seconds, peak):
    schedule = simulated(alone(2.0, 2.0, 2.0), 8, memory)
    assert (schedule.seconds, schedule.mib) == (seconds, peak)


def test_a_small_job_passes_one_that_there_is_no_memory_for():
    large, small = alone(3.0, mib=200.0)[0], alone(1.0, mib=50.0)[0]
    schedule = simulated([large, Job([Stage("other", 2.0)], 200.0), small], 3, 260.0)
    assert (schedule.seconds, schedule.mib) == (5.0, 250.0)


def test_busy_seconds_count_overlaps_once_and_gaps_not_at_all():
    at = "2026-01-01T00:00:{:02d}+00:00"
    stages = pd.DataFrame({"started": [at.format(s) for s in (0, 2, 30)], "wall_s": [5.0, 5.0, 1.5]})
    assert SCALING["busy_seconds"](stages) == pytest.approx(8.5)


def test_the_page_shows_the_numbers_of_the_committed_results():
    """Otherwise run `python docs/scaling.py`."""
    assert SCALING["main"]([str(SCRIPT), "--check"]) == 0, f"run `{Path(sys.executable).name} docs/scaling.py`"
