"""No more jobs run at once than there is memory for."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from repro.launch import machine
from repro.launch.jobs import Job
from repro.launch.machine import SHARE, memory_for_jobs_mib
from repro.launch.pool import _Launcher


def launcher(sizes, workers, memory_mib):
    jobs = [(number, Job(str(number), "", expected_mib=size)) for number, size in enumerate(sizes)]
    return _Launcher(jobs, workers, memory_mib, None, lambda event: None, logs=None)


def start(launcher):
    """What is started until no more may be; the jobs' sizes in MiB."""
    while (place := launcher._next()) is not None:
        launcher.running.append(SimpleNamespace(job=launcher.waiting.pop(place)[1]))
    return [job.job.expected_mib for job in launcher.running]


def test_the_first_that_fits_is_next_and_a_job_alone_always_runs():
    jobs = launcher([500, 400, 300, 100, 100], 4, 900)
    assert start(jobs) == [500, 400]
    del jobs.running[0]
    assert start(jobs) == [400, 300, 100, 100]
    assert start(launcher([5000, 1], 4, 900)) == [5000]
    assert start(launcher([1, 5000, 2], 2, 900)) == [1, 2]


def test_sixty_four_cores_with_eight_gib_are_never_given_more_than_there_is():
    generator = np.random.default_rng(0)
    limit = SHARE * 8192
    jobs = launcher(generator.uniform(300, 1200, 200).tolist(), 64, limit)
    most = 0.0
    while jobs.waiting or jobs.running:
        total = sum(start(jobs))
        most = max(most, total)
        assert total <= limit <= 6.5 * 1024
        del jobs.running[generator.integers(len(jobs.running))]
    assert most > 0.8 * limit


@pytest.mark.parametrize(
    ("limit", "expected"), [("max\n", 4000.0), (f"{3000 * 1024**2}\n", 3000.0), (f"{9000 * 1024**2}\n", 4000.0)]
)
def test_a_container_may_allow_less_than_is_available(limit, expected, monkeypatch):
    texts = {machine.LIMITS[0]: limit, "/proc/meminfo": f"MemTotal: 1 kB\nMemAvailable: {4000 * 1024} kB\n"}
    monkeypatch.setattr(machine, "_text", lambda file: texts.get(file, ""))
    assert memory_for_jobs_mib() == pytest.approx(SHARE * expected)


def test_where_nothing_is_known_nothing_is_limited(monkeypatch):
    monkeypatch.setattr(machine, "_text", lambda file: "")
    assert memory_for_jobs_mib() == float("inf")


@pytest.mark.skipif(sys.platform != "linux", reason="counts the page faults of GNU's C library")
def test_freed_memory_is_used_again():
    """A second array of 64 MiB takes no new pages from the system."""
    script = (
        "import numpy, resource; from repro.launch.machine import reuse_freed_memory; reuse_freed_memory()\n"
        "faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt\n"
        "counts = []\n"
        "for _ in range(3):\n"
        "    before = faults(); numpy.ones(2**23); counts.append(faults() - before)\n"
        "print(*counts)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    first, *others = map(int, done.stdout.split())
    assert max(others) < first / 10
