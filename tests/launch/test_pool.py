"""Whatever a job does, it costs that job alone."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path

JOBS = """
    import os, signal, subprocess, time
    from repro.tracking import progress

    def double(x):
        return 2 * x
    def raises():
        print("before the error")
        raise ValueError("no such\\nthing")
    def leaves():
        os._exit(3)
    def is_killed():
        os.kill(os.getpid(), signal.SIGKILL)
    def crashes():
        os.abort()
    def hangs():
        subprocess.run(["sleep", "100"])
    def answers_oddly():
        return lambda: 1
    def reports():
        for step in range(3):
            progress.report(step / 3, f"step {step}")
            time.sleep(0.25)
        progress.notice("look here")
        return "done"
    def waits(seconds):
        started()
        time.sleep(seconds)
    def ignores(seconds):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        started()
        time.sleep(seconds)
    def started():
        open(os.path.join(os.environ["REPRO_OUTPUTS"], f"started-{os.getpid()}"), "w").close()
"""

ENDINGS = """
    import json
    from repro.launch.jobs import Job, failure_table
    from repro.launch.pool import run_jobs
    names = ["raises", "leaves", "is_killed", "crashes", "hangs", "answers_oddly", "missing"]
    jobs = [Job("first", "toyjobs:double", {"x": 1})]
    jobs += [Job(name, f"toyjobs:{name}", command=f"repro run {name}") for name in names]
    jobs += [Job("last", "toyjobs:double", {"x": 2})]
    order = []
    note = lambda event: order.append((event.kind, jobs[event.index].name))
    results = run_jobs(jobs, workers=2, timeout_s=1.0, preload=(), on_progress=note)
    rows = [[r.job.name, r.outcome, r.value, r.error, r.log] for r in results]
    print(json.dumps({"rows": rows, "order": order, "table": failure_table(results)}))
"""


def output_of(process, timeout=60):
    output, _ = process.communicate(timeout=timeout)
    assert process.returncode == 0, output
    return json.loads(output.splitlines()[-1])


def test_every_ending_costs_that_job_alone(start):
    told = output_of(start(ENDINGS, JOBS))
    outcomes = {name: outcome for name, outcome, *_ in told["rows"]}
    assert outcomes == {
        "first": "ok",
        "raises": "failed",
        "leaves": "killed",
        "is_killed": "killed",
        "crashes": "killed",
        "hangs": "timed out",
        "answers_oddly": "failed",
        "missing": "failed",
        "last": "ok",
    }
    assert [value for _, outcome, value, *_ in told["rows"] if outcome == "ok"] == [2, 4]
    messages = {name: error for name, _, _, error, _ in told["rows"]}
    assert messages["raises"] == "ValueError: no such\nthing"
    assert "exit code 3" in messages["leaves"]
    assert "SIGKILL" in messages["is_killed"] and "memory" in messages["is_killed"]
    assert "SIGABRT" in messages["crashes"]
    assert messages["hangs"].startswith("killed after 1")
    assert "missing" in messages["missing"]
    # Told at once: a failure is reported before a later job starts.
    order = [tuple(one) for one in told["order"]]
    assert order.index(("ended", "raises")) < order.index(("started", "hangs"))
    assert "7 of 9 jobs failed" in told["table"]
    assert "raises: failed: ValueError: no such\n" in told["table"]
    assert "repeat: repro run crashes" in told["table"]


def test_what_a_job_prints_lies_in_its_log(start):
    told = output_of(start(ENDINGS, JOBS))
    logs = {name: log for name, *_, log in told["rows"]}
    text = Path(logs["raises"]).read_text()
    assert text.startswith("before the error\nTraceback")
    assert logs["first"] == ""


def test_progress_and_notices_reach_the_caller(start):
    told = output_of(
        start(
            """
            import json
            from repro.launch.jobs import Job
            from repro.launch.pool import run_jobs
            seen = []
            run_jobs([Job("a", "toyjobs:reports")], workers=1, preload=(),
                     on_progress=lambda e: seen.append([e.kind, e.fraction, e.text]))
            print(json.dumps(seen))
            """,
            JOBS,
        )
    )
    assert told == [
        ["started", None, ""],
        ["progress", 0.0, "step 0"],
        ["progress", 1 / 3, "step 1"],
        ["progress", 2 / 3, "step 2"],
        ["notice", None, "look here"],
        ["ended", None, ""],
    ]


def test_the_same_job_twice_gives_equal_bits_on_one_thread(start):
    told = output_of(
        start(
            """
            import json
            from repro.launch.jobs import Job
            from repro.launch.pool import run_jobs
            results = run_jobs([Job(str(n), "toyjobs:multiplies") for n in range(2)], workers=2, preload=("numpy",))
            print(json.dumps([result.value for result in results]))
            """,
            """
            import hashlib, numpy as np
            from threadpoolctl import threadpool_info
            def multiplies():
                a = np.random.default_rng(0).standard_normal((500, 500))
                threads = [pool["num_threads"] for pool in threadpool_info()]
                return hashlib.sha256(np.linalg.solve(a, a @ a.T).tobytes()).hexdigest(), threads
            """,
        )
    )
    assert told[0] == told[1]
    assert set(told[0][1]) == {1}


def test_a_fresh_trivial_job_costs_well_under_three_tenths_of_a_second(start):
    seconds = output_of(
        start(
            """
            import json, time
            from repro.launch.jobs import Job
            from repro.launch.pool import run_jobs
            jobs = [Job(str(x), "toyjobs:double", {"x": x}) for x in range(100)]
            run_jobs(jobs[:1], workers=2, preload=("numpy",))
            start = time.perf_counter()
            results = run_jobs(jobs, workers=2, preload=("numpy",))
            assert all(result.ok for result in results)
            print(json.dumps((time.perf_counter() - start) / 100))
            """,
            JOBS,
        )
    )
    assert seconds < 0.1


def test_logs_that_cannot_be_written_are_explained(start, tmp_path):
    (tmp_path / "file").write_text("")
    told = output_of(
        start(
            f"""
            import json
            from pathlib import Path
            from repro.launch.jobs import Job, reason
            from repro.launch.pool import run_jobs
            jobs = [Job("a", "toyjobs:double", {{"x": 1}})]
            results = run_jobs(jobs, workers=1, preload=(), logs=Path({str(tmp_path)!r}) / "file" / "logs")
            print(json.dumps([reason(result) for result in results]))
            """,
            JOBS,
        )
    )
    assert told[0].startswith("failed: NotADirectoryError")


def test_a_fault_of_the_callers_display_is_not_the_jobs(start):
    told = output_of(
        start(
            """
            import json
            from repro.launch.jobs import Job
            from repro.launch.pool import run_jobs
            def shows(event):
                if event.kind == "progress":
                    raise OSError("no display")
            try:
                run_jobs([Job("a", "toyjobs:reports")], workers=1, preload=(), on_progress=shows)
            except OSError as error:
                print(json.dumps(str(error)))
            """,
            JOBS,
        )
    )
    assert told == "no display"


INTERRUPTED = """
    import json, sys
    from repro.launch.jobs import Job
    from repro.launch.pool import run_jobs
    jobs = [Job(str(i), "toyjobs:TARGET", {"seconds": 30}) for i in range(4)]
    try:
        run_jobs(jobs, workers=2, preload=())
    except KeyboardInterrupt as stop:
        print(json.dumps([result.outcome for result in stop.args[0]]))
"""


def wait_for_started(root, count):
    deadline = time.monotonic() + 20
    while len(list(root.glob("started-*"))) < count:
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_ctrl_c_once_ends_running_jobs_gracefully(root, start):
    root.mkdir()
    sweep = start(INTERRUPTED.replace("TARGET", "waits"), JOBS)
    wait_for_started(root, 2)
    sweep.send_signal(signal.SIGINT)
    assert output_of(sweep, timeout=10) == ["interrupted", "interrupted", "not started", "not started"]


def test_ctrl_c_twice_kills(root, start):
    root.mkdir()
    sweep = start(INTERRUPTED.replace("TARGET", "ignores"), JOBS)
    wait_for_started(root, 2)
    sweep.send_signal(signal.SIGINT)
    time.sleep(0.5)
    assert sweep.poll() is None
    sweep.send_signal(signal.SIGINT)
    assert output_of(sweep, timeout=10) == ["interrupted", "interrupted", "not started", "not started"]


def test_jobs_die_with_their_launcher(root, start):
    import psutil

    root.mkdir()
    sweep = start(INTERRUPTED.replace("TARGET", "ignores"), JOBS)
    wait_for_started(root, 2)
    jobs = [psutil.Process(int(file.name.partition("-")[2])) for file in root.glob("started-*")]
    sweep.kill()
    sweep.communicate()
    _, alive = psutil.wait_procs(jobs, timeout=5)
    assert alive == []


def test_an_edit_during_a_sweep_changes_no_job_of_it(root, start, tmp_path):
    """A module that the server has loaded keeps its old code and its old digest; a fresh one has the new ones."""
    package = tmp_path / "repro_edited.py"
    package.write_text("value = 1\n")
    jobs = """
        import repro_edited
        from repro.tracking import code
        code.__name__ = "repro_edited.code"  # so that the toy counts as the package itself
        def look():
            return [repro_edited.value, code.closure(("repro_edited",)).code["repro_edited"]]
    """
    told = output_of(
        start(
            f"""
            import json, time
            from pathlib import Path
            from repro.tracking import code
            from repro.launch.jobs import Job
            from repro.launch.pool import run_jobs
            time.sleep(0.02)
            jobs = [Job("a", "toyjobs:look")]
            first = run_jobs(jobs, workers=1, preload=("toyjobs",))
            time.sleep(0.02)
            Path({str(package)!r}).write_text("value = 2\\n")
            second = run_jobs(jobs, workers=1, preload=("toyjobs",))
            new = code.closure(("repro_edited",)).code["repro_edited"]
            print(json.dumps([first[0].value, second[0].value, new]))
            """,
            jobs,
        )
    )
    first, second, new = told
    assert first[0] == second[0] == 1
    assert first[1] == second[1] != new
