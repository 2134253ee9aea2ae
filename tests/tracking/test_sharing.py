"""Kills at random moments and several invocations at once: no half run counts, no finished run is repeated."""

from __future__ import annotations

import json
import os
import random
import signal
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest

from repro.tracking import lock
from repro.tracking.store import Store

STAGES = 25
WORKERS = 2

JOBS = """
    import os, time
    from pathlib import Path
    from repro.tracking.paths import outputs_root
    from repro.tracking.stage import Stage
    from repro.tracking.store import Store

    def note(number):
        descriptor = os.open(outputs_root() / "starts.txt", os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(descriptor, f"{number}\\n".encode())
        os.close(descriptor)

    def make(number):
        def work(folder):
            note(number)
            with open(folder / "table.csv", "w") as file:
                for row in range(4):
                    file.write(f"{number},{row}\\n" * 1000)
                    file.flush()
                    time.sleep(0.005)
            return {"number": number}

        stage = Stage("fits", f"toy {number}", {"number": number}, {}, ("toyjobs",))
        return Store(outputs_root()).compute(stage, work).id
"""

SWEEP = f"""
    import json
    from repro.launch.jobs import Job
    from repro.launch.pool import run_jobs
    jobs = [Job(str(number), "toyjobs:make", {{"number": number}}) for number in range({STAGES})]
    results = run_jobs(jobs, workers={WORKERS}, preload=("repro.tracking.store",))
    print(json.dumps([[result.outcome, result.value] for result in results]))
"""


def starts(root):
    file = root / "starts.txt"
    return Counter(file.read_text().split()) if file.exists() else Counter()


def check_whole(store):
    """Every folder that counts is whole to the last byte; returns the numbers of the finished stages by id."""
    found = {id: store.find(id, kind="fits", verify=True) for id in store.paths.ids("fits")}
    assert [id for id, record in found.items() if record is None] == []
    return {id: str(record.summary["number"]) for id, record in found.items()}


def kill_and_resume(root, start, kills):
    store = Store(root)
    dice = random.Random(7)
    root.mkdir()
    starts_when_finished = {}
    for _ in range(kills):
        before = set(store.paths.ids("fits", ".work"))
        sweep = start(SWEEP, JOBS)
        time.sleep(dice.uniform(0.2, 0.7))
        one_more = sweep.poll() is None and dice.random() < 0.3
        if one_more:
            # One job dies before its sweep.
            for job in _jobs_of(sweep)[:1]:
                os.kill(job, signal.SIGKILL)
            time.sleep(0.1)
        sweep.kill()
        sweep.communicate()
        for number in check_whole(store).values():
            starts_when_finished.setdefault(number, starts(root)[number])
        in_flight = set(store.paths.ids("fits", ".work")) - before
        assert len(in_flight) <= WORKERS + one_more
    final = start(SWEEP, JOBS)
    output, _ = final.communicate(timeout=120)
    results = json.loads(output.splitlines()[-1])
    assert [outcome for outcome, _ in results] == ["ok"] * STAGES
    assert sorted(id for _, id in results) == sorted(check_whole(store))
    assert store.paths.ids("fits", ".work") == []
    assert {number: starts(root)[number] for number in starts_when_finished} == starts_when_finished


def _jobs_of(sweep):
    """Process numbers of a sweep's jobs: they share its session and lead a process group each."""
    found = []
    for pid in sorted(int(path.name) for path in Path("/proc").glob("[0-9]*")):
        with suppress(ProcessLookupError):
            if pid != sweep.pid and os.getsid(pid) == sweep.pid and os.getpgid(pid) == pid:
                found.append(pid)
    return found


def test_six_kills(root, start):
    kill_and_resume(root, start, 6)


@pytest.mark.slow
def test_fifty_kills(root, start):
    kill_and_resume(root, start, 50)


@pytest.mark.parametrize("invocations", [2, 4])
def test_invocations_at_once_share_the_work(root, start, invocations):
    root.mkdir()
    sweeps = [start(SWEEP, JOBS) for _ in range(invocations)]
    outputs = [sweep.communicate(timeout=120)[0] for sweep in sweeps]
    results = [json.loads(output.splitlines()[-1]) for output in outputs]
    assert all(one == results[0] for one in results)
    assert [outcome for outcome, _ in results[0]] == ["ok"] * STAGES
    assert len(check_whole(Store(root))) == STAGES
    assert set(starts(root).values()) == {1}


def test_the_lock_of_a_dead_process_blocks_nobody(root, start):
    root.mkdir()
    forever = """
        import time
        from repro.tracking import lock
        from repro.tracking.paths import Paths, outputs_root
        with lock.held(Paths(outputs_root()).lock("fits", "x"), outputs_root() / "holder.json", "x"):
            print("held", flush=True)
            time.sleep(100)
    """
    file = root / "fits" / ".lock" / "x.lock"
    process = start(forever)
    assert process.stdout.readline() == "held\n"
    assert lock.is_held(file)
    process.kill()
    process.communicate()
    assert not lock.is_held(file)
    with lock.held(file, root / "holder.json", "x"):
        assert lock.is_held(file)
