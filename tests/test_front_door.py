"""What a user meets where the machine, the shell or the store is not as it should be: one line, the right exit code."""

import os
import shlex
import shutil
import subprocess
import sys
import time
import warnings
from importlib import metadata
from pathlib import Path

import pytest

import repro
from repro import __main__ as cli
from repro.commands import completion
from repro.config import places, registry
from repro.config.compose import compose
from repro.errors import UserError
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.recording import viewer
from repro.sweep.expected_cost import MeasuredStages, expected_seconds
from repro.sweep.planned_job import PlannedJob
from repro.tracking import paths
from repro.tracking.paths import Paths
from repro.tracking.store import Store
from repro.tracking.survey import StageState, survey
from repro.tracking.text import terminal_width

TINY = ["basis=t1", "optimiser=least_squares", "scale=smoke", "seeds=1", "record=false"]


def shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """A line of bash in which `repro` is this project's."""
    program = line.replace("repro ", f"{shlex.quote(sys.executable)} -m repro ")
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", program],
        cwd=folder, capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, "REPRO_OUTPUTS": str(folder / "outputs"), **environment},
    )  # fmt: skip


# A line of bash, its exit code, and what its one line says.
ENDINGS = {
    "closed output": ("repro status >&-", 0, ""),
    "closed output and error": ("repro status >&- 2>&-", 0, ""),
    "full device": ("repro status > /dev/full", 1, "repro: cannot write the output: No space left on device"),
    "reader gone": ("repro runs --json | true", 0, ""),
    "deleted folder": ("mkdir gone; cd gone; rmdir ../gone; repro status", 2, "the working folder was deleted"),
    "a file": ("REPRO_OUTPUTS=/dev/null repro status", 2, "/dev/null is a file, not a folder"),
    "below a file": ("REPRO_OUTPUTS=/dev/null/x repro status", 2, "/dev/null is a file, not a folder"),
    "a mistake": ("repro run data.samples=-5", 2, "greater than or equal to 10"),
}


@pytest.mark.slow
@pytest.mark.parametrize("ending", ENDINGS)
def test_a_bad_place_is_one_line(ending, tmp_path):
    line, code, said = ENDINGS[ending]
    done = shell(line, tmp_path)
    assert done.returncode == code, done.stderr
    assert said in done.stderr and "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) == (1 if said else 0)


@pytest.mark.slow
def test_a_folder_that_cannot_be_made_is_not_called_full(tmp_path):
    done = shell(f"repro run {' '.join(TINY)}", tmp_path, REPRO_OUTPUTS="/proc/nothing")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("repro: /proc/nothing cannot be made; choose another folder")
    assert "full" not in done.stderr and "Traceback" not in done.stderr


def test_a_tilde_is_the_home(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("REPRO_OUTPUTS", "~/results")
    assert paths.outputs_root() == tmp_path / "results"


def test_memory_and_other_failures_of_the_machine_are_one_line(monkeypatch, capsys):
    for trouble, said in (
        (MemoryError(), "not enough memory"),
        (OSError(12, "Cannot allocate memory", "libtorch.so"), "libtorch.so: Cannot allocate memory"),
    ):
        monkeypatch.setattr("repro.commands.status.main", lambda argv, trouble=trouble: (_ for _ in ()).throw(trouble))
        assert cli.main(["status"]) == 1
        err = capsys.readouterr().err
        assert said in err and len(err.splitlines()) == 1


def test_without_a_home_there_are_caches(monkeypatch, tmp_path):
    from repro.codegen.c_library import cache_folder

    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", lambda uid: (_ for _ in ()).throw(KeyError(uid)))
    assert cache_folder().is_dir()
    assert paths.source_cache().is_absolute()
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc")
    assert cache_folder().is_dir() and not cache_folder().is_relative_to("/proc")


def test_without_its_settings_the_package_says_that_it_needs_the_checkout(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(places, "CONF", tmp_path / "conf")
    registry.groups.cache_clear()
    for line in (["run", "--help"], ["run", "basis=t1"], ["identify", "basis=t1"], ["reproduce"]):
        assert cli.main(line) == 2
        assert "needs the project's checkout" in capsys.readouterr().err
    registry.groups.cache_clear()


@pytest.mark.slow
def test_a_mistake_in_a_pipe_ends_with_its_command(tmp_path):
    """The server of jobs, which loads in the background, holds the pipe no longer than the command runs."""
    alone, piped = ([], [])
    for _ in range(2):
        for taken, line in ((alone, "repro run data.samples=-5"), (piped, "repro run data.samples=-5 2>&1 | cat")):
            start = time.monotonic()
            assert "greater than or equal to 10" in "".join(shell(line, tmp_path).stdout + shell(line, tmp_path).stderr)
            taken.append((time.monotonic() - start) / 2)
    assert min(piped) < min(alone) + 0.7


@pytest.mark.slow
def test_the_server_ends_with_a_command_that_is_killed(tmp_path):
    program = (
        "import sys, time; from repro.launch.pool import start_server; from multiprocessing import forkserver;"
        "start_server(['repro.pipeline.run']); print(forkserver._forkserver._forkserver_pid, flush=True);"
        "time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    server = int(process.stdout.readline())
    process.kill()
    process.wait()
    process.stdout.close()
    assert gone(server, 10)


def gone(pid: int, seconds: float) -> bool:
    """Whether a process ends within so many seconds."""
    for _ in range(int(seconds * 10)):
        state = Path(f"/proc/{pid}/stat")
        if not state.exists() or state.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.1)
    return False


KILLS_ITS_SERVER = """
import os, signal, sys
from multiprocessing import forkserver
from repro.launch import pool
from repro.launch.pool import run_jobs
from repro.launch.jobs import Job
from repro import __main__ as cli
def main(argv):
    run_jobs([Job("one", "os:getpid")], workers=1, preload=())
    server = forkserver._forkserver
    server.ensure_running = lambda: None
    os.kill(server._forkserver_pid, signal.SIGKILL)
    run_jobs([Job("two", "os:getpid")], workers=1, preload=())
import repro.commands.status as status
status.main = main
sys.exit(cli.main(["status"]))
"""


@pytest.mark.slow
def test_a_killed_server_is_one_line(tmp_path):
    environment = {**os.environ, "REPRO_OUTPUTS": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", KILLS_ITS_SERVER], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode in (1, 2) and "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("how", ["file", "stdin", "asyncio"])
def test_a_script_without_a_guard_may_run_jobs(how, tmp_path):
    call = f"main(['run', *{TINY!r}])"
    script = f"from repro.__main__ import main\n{call}\n"
    if how == "asyncio":
        script = f"import asyncio\nfrom repro.__main__ import main\nasync def all():\n    {call}\nasyncio.run(all())\n"
    (tmp_path / "script.py").write_text(script)
    done = shell(f"{sys.executable} script.py" if how != "stdin" else f"{sys.executable} - < script.py", tmp_path)
    assert done.returncode == 0 and "Traceback" not in done.stderr and "killed" not in done.stderr
    assert len(list((tmp_path / "outputs" / "runs").glob("*/run.json"))) == 1


@pytest.fixture
def finished(tmp_path, monkeypatch):
    """A finished run in a store of its own."""
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    composed = compose([*TINY, "data.samples=200", "data.episode_steps=100"])
    store = Store(tmp_path / "outputs")
    record = execute(Pipeline.of(composed.config, composed.command), store)
    return PlannedJob.of(composed), store, record


@pytest.mark.parametrize("kind", ["data", "fits"])
def test_what_was_deleted_by_hand_is_noticed_and_made_again(kind, finished, capsys):
    job, store, record = finished
    assert job.pipeline.finished(store) is not None
    (folder,) = store.paths.root.glob(f"{kind}/sip*")
    shutil.rmtree(folder)
    (missing,) = [item for item in survey(Paths(store.paths.root)) if item.state is StageState.MISSING]
    assert (missing.kind, missing.id) == (kind, folder.name) and "deleted" in missing.why[0]
    if kind == "fits":
        assert cli.main(["export", record.id, "exported"]) == 2
        assert "was deleted; this makes it again: repro run" in capsys.readouterr().err
    assert job.pipeline.finished(store) is None
    execute(job.pipeline, store)
    assert job.pipeline.finished(store) is not None and folder.is_dir()


def test_a_report_of_plain_runs_shows_them(finished, capsys):
    _, _, record = finished
    assert cli.main(["report"]) == 0
    shown = capsys.readouterr().out
    assert (
        record.id.rpartition("-")[2] in shown and "1 run there belongs to none" in shown and "repro reproduce" in shown
    )


def test_columns_of_the_terminal_are_kept_to(finished, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "40")
    assert terminal_width() == 40
    assert cli.main(["runs"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= 40 for line in lines if not line.startswith("not shown"))


def test_a_filter_by_a_column_that_no_run_has_is_a_mistake(finished, capsys):
    assert cli.main(["runs", "bsis=t1"]) == 2
    assert "no column bsis (did you mean basis?)" in capsys.readouterr().err
    with pytest.raises(UserError, match="no column mdel"):
        repro.load_runs(mdel="x")


def test_a_value_that_no_run_has_is_told(finished):
    with pytest.warns(UserWarning, match="no run has n_train='480'; there are 160"):
        assert repro.load_runs(n_train="480").empty
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not repro.load_runs(n_train=160).empty


def test_a_store_may_be_named_by_text(finished):
    _, store, record = finished
    assert repro.load_run(record.id, root=str(store.paths.root)).id == record.id
    assert set(repro.load_runs(root=str(store.paths.root))["run"]) == {record.id}


def test_files_that_a_system_leaves_are_no_lists(finished):
    _, store, record = finished
    folder = store.paths.experiments / "quick"
    folder.mkdir(parents=True)
    (folder / "._sip_basis.json").write_bytes(b"\x00\x05\x16\x07")
    assert set(repro.load_runs()["run"]) == {record.id}
    assert cli.main(["status"]) == 0
    (folder / "sip_basis.json").write_text("")
    with pytest.raises(UserError, match=r"sip_basis\.json cannot be read"):
        repro.load_runs()


def test_closed_loops_go_on_where_they_were_stopped(tmp_path, monkeypatch):
    import pandas as pd

    from repro.control.task import Task
    from repro.library import closed_loops
    from repro.pipeline.stages import close_loops

    composed = compose(["model=truth", "control=energy_shaping", "task=random", "task.seconds=2", "seeds=2"])
    config = composed.config
    assert isinstance(config.task, Task)
    pipeline = Pipeline.of(config, "")
    store = Store(tmp_path / "outputs")
    run_loop, calls = closed_loops.run_loop, []

    def stopped(*arguments, **more):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return run_loop(*arguments, **more)

    monkeypatch.setattr(closed_loops, "run_loop", stopped)
    with pytest.raises(KeyboardInterrupt):
        execute(pipeline, store)
    execute(pipeline, store)
    loops = config.loops
    assert len(calls) == loops + 1  # the third one twice, the first two once
    monkeypatch.setattr(closed_loops, "run_loop", run_loop)
    other = Store(tmp_path / "other")
    execute(pipeline, other)
    one, two = (
        pd.read_parquet(each.paths.folder("control", pipeline.control_stage.id) / close_loops.LOOPS)
        for each in (store, other)
    )
    timed = [name for name in one if "_ms_" in name]
    pd.testing.assert_frame_equal(one.drop(columns=timed), two.drop(columns=timed))


def test_the_estimate_of_a_closed_form_grows_with_its_samples(tmp_path):
    times = MeasuredStages(Paths(tmp_path))

    def seconds(*overrides):
        return expected_seconds(
            Pipeline.of(compose(["basis=t1", "optimiser=least_squares", *overrides]).config, ""), times
        )

    assert seconds("data.samples=1000000000") > 1000 * seconds()
    assert seconds("seeds=2000") > 20 * seconds()


@pytest.mark.parametrize("path", ["a,b.csv", "a b.csv", "a'b.csv", 'a"b.csv', "a#b.csv", "a&b.csv", "(1).csv", "ä.csv"])
def test_the_command_of_a_file_can_be_pasted(path, tmp_path):
    """What is printed gives the same override again in a shell."""
    from repro.config.compose import Composed

    override = f'data.path="{path}"'
    words = subprocess.run(
        ["bash", "-c", f"printf '%s\\n' {Composed((override,), None).command}"],  # type: ignore[arg-type]
        capture_output=True, text=True, check=True,
    ).stdout.splitlines()  # fmt: skip
    assert words == ["repro", "run", override]


def test_a_display_that_does_not_answer_is_as_none(monkeypatch, tmp_path):
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", ":4711")
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(UserError, match="no display here"):
        viewer.open_window(tmp_path / "recording.rrd")


def test_help_and_module_are_the_same_program(tmp_path):
    assert metadata.version("repro") in shell("repro --version", tmp_path).stdout


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("repro st", ["status"]),
        ("repro run sys", ["system.", "system="]),
        ("repro run system=si", ["system=sip", "system=sip_rod"]),
        ("repro run -m basis=t1,t", ["basis=t1,t1", "basis=t1,t2"]),
        ("repro run data=episodes data.samples", ["data.samples="]),
        ("repro run --dry", ["--dry-run"]),
        ("repro reproduce experiment=sip_b", ["experiment=sip_basis"]),
        ("repro completion z", ["zsh"]),
        ("repro nothing x", []),
    ],
)
def test_a_shell_completes(line, expected):
    assert completion.candidates(line) == expected


@pytest.mark.parametrize("name", ["bash", "zsh", "fish"])
def test_a_script_of_a_shell_is_understood_by_it(name, capsys, tmp_path):
    assert cli.main(["completion", name]) == 0
    (tmp_path / "script").write_text(capsys.readouterr().out)
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")
    done = subprocess.run([name, "-n", str(tmp_path / "script")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_ids_are_completed(finished):
    _, _, record = finished
    assert completion.candidates("repro show sip") == [record.id]
