"""The front door is light, says what it can do, and ends calmly."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import time

import pytest

from repro import __main__ as cli
from repro.errors import UserError
from repro.tracking.paths import FAILED
from repro.tracking.stage import Stage
from repro.tracking.store import StageFailed, Store

HEAVY = ("torch", "numpy", "pandas", "pyarrow", "casadi", "hydra", "rerun", "matplotlib", "rich", "scipy")


@pytest.fixture
def store(tmp_path, monkeypatch):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    return Store(tmp_path / "outputs")


@pytest.fixture
def records(store):
    """Two finished runs and a failed one."""

    def stage(n):
        return Stage("runs", "toy", {"n": n}, {}, ("repro.errors",), command=f"repro run n={n}")

    def fails(folder):
        raise ValueError("loss is not finite")

    made = [store.compute(stage(n), lambda folder, n=n: {"card": {"model": f"m{n}"}}) for n in (1, 2)]
    with pytest.raises(StageFailed) as caught:
        store.compute(stage(3), fails)
    return [*made, caught.value.record]


@pytest.mark.parametrize("arguments", [["--help"], ["status"], ["runs"]])
def test_light_commands_load_nothing_heavy(tmp_path, arguments):
    program = (
        "import sys; from repro.__main__ import main; code = main(sys.argv[1:]);"
        f"print(code, [name for name in {HEAVY!r} if name in sys.modules])"
    )
    environment = {**os.environ, "REPRO_OUTPUTS": str(tmp_path)}
    output = subprocess.run(
        [sys.executable, "-c", program, *arguments], check=True, capture_output=True, text=True, env=environment
    ).stdout
    assert output.splitlines()[-1] == "0 []"


def test_help_lists_the_commands_with_examples(capsys):
    assert cli.main([]) == 0
    text = capsys.readouterr().out
    for name, command in cli.COMMANDS.items():
        assert f"  {name} " in text and f"repro {name} {command.example}".rstrip() in text
    assert "repro status --why" in text
    assert all(len(line) < 120 for line in text.splitlines())


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_each_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main([command, "--help"])
    assert stop.value.code == 0
    usage, _, output = capsys.readouterr().out.partition("\n\n")
    assert usage.startswith(f"usage: repro {command} ")
    description, _, example = output.partition("example")
    assert description.strip()
    assert f"repro {command}" in example


def test_a_typing_mistake_is_answered(capsys):
    assert cli.main(["statsu"]) == 2
    assert "Did you mean status?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("trouble", "code", "expected"),
    [
        (UserError("no model lagrangain; choose from lagrangian"), 2, "repro: no model lagrangain"),
        (KeyboardInterrupt(), 130, "Finished work is kept; to go on: repro status"),
    ],
)
def test_troubles_end_calmly(monkeypatch, capsys, trouble, code, expected):
    def raises(argv):
        raise trouble

    monkeypatch.setattr("repro.commands.status.main", raises)
    monkeypatch.setattr("shutil.which", lambda name: f"/usr/bin/{name}")
    assert cli.main(["status"]) == code
    output = capsys.readouterr().err
    assert expected in output
    assert "Traceback" not in output


def test_a_closed_pipe_is_no_error(store, records):
    program = f"{shlex.quote(sys.executable)} -m repro runs --json | head -c 1"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert done.stderr == ""


def test_status_counts_and_explains(store, records, capsys):
    assert cli.main(["status"]) == 0
    text = capsys.readouterr().out
    assert "done" in text and "failed" in text
    assert "ValueError: loss is not finite" in text
    assert cli.main(["status", "--why", records[2].id]) == 0
    assert "made by: repro run n=3" in capsys.readouterr().out
    assert cli.main(["status", "--json"]) == 0
    output = json.loads(capsys.readouterr().out)
    assert sorted(item["state"] for item in output) == ["done", "done", "failed"]
    assert cli.main(["status", "--why", "nothing"]) == 2


def test_status_of_an_empty_store(store, capsys):
    assert cli.main(["status"]) == 0
    assert "repro reproduce" in capsys.readouterr().out


def test_runs_lists_and_filters(store, records, capsys):
    assert cli.main(["runs", "model=m2"]) == 0
    text = capsys.readouterr().out
    assert records[1].id.rpartition("-")[2] in text
    assert records[0].id.rpartition("-")[2] not in text
    assert cli.main(["runs"]) == 0
    assert "model" in capsys.readouterr().out.splitlines()[0]
    assert cli.main(["runs", "m2"]) == 2
    assert "write key=value" in capsys.readouterr().err


def test_show_tells_results_and_failures(store, records, capsys):
    assert cli.main(["show", records[0].id[-10:]]) == 0
    text = capsys.readouterr().out
    assert "repro run n=1" in text and "commit" in text
    assert re.search(r"\ncard\n  model +m1\n", text)
    assert cli.main(["show", records[2].id]) == 0
    assert 'raise ValueError("loss is not finite")' in capsys.readouterr().out
    assert cli.main(["show", records[0].id, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["id"] == records[0].id


def test_diff_tells_what_differs(store, records, capsys):
    assert cli.main(["diff", records[0].id, records[1].id]) == 0
    text = capsys.readouterr().out
    assert re.search(r"^config\n  n  1  ->  2$", text, re.MULTILINE)
    assert re.search(r"^  card.model +m1 +-> +m2$", text, re.MULTILINE)


def test_clean_shows_first_and_keeps_what_counts(store, records, capsys):
    assert cli.main(["clean"]) == 0
    assert "add --yes" in capsys.readouterr().out
    assert store.find(records[2].id, shelf=FAILED) is not None
    assert cli.main(["clean", "--yes"]) == 0
    assert store.find(records[2].id, shelf=FAILED) is None
    assert [record.id for record in store.records("runs")] == sorted(record.id for record in records[:2])
    assert cli.main(["clean", "everything"]) == 2


def test_clean_leaves_running_work_alone(store, capsys):
    def work(folder):
        (folder / "checkpoint.pt").write_text("epoch 1")
        cli.main(["clean", "--yes"])
        assert (folder / "checkpoint.pt").exists()
        return {}

    assert store.compute(Stage("runs", "toy", {}, {}, ("repro.errors",)), work).outcome == "ok"


def test_old_logs_go(store, capsys):
    for name, age_days in (("old", 8), ("new", 1)):
        folder = store.paths.logs / name
        folder.mkdir(parents=True)
        os.utime(folder, (time.time() - age_days * 86400,) * 2)
    assert cli.main(["clean", "logs", "--yes"]) == 0
    assert [folder.name for folder in store.paths.logs.iterdir()] == ["new"]
