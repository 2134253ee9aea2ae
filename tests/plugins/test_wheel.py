"""The wheel in a new environment, in a folder elsewhere: every command works, or says in a line what it needs."""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RUN = ["run", "basis=t1", "optimiser=least_squares", "scale=smoke", "seeds=1"]
FIT = """
import repro
data = repro.simulate("sip", samples=200, reset="random")
fitted = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares", system=repro.system("sip"))
assert fitted.record("fit.rrd").is_file()
print(repro.__file__)
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder of the programs of an environment with the wheel, and a folder to work in."""
    place, here = tmp_path_factory.mktemp("new environment"), tmp_path_factory.mktemp("wörk (1)")
    wheels = tmp_path_factory.mktemp("wheels")
    venv.create(place)
    python = place / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", str(wheels), str(ROOT)], check=True)
    (wheel,) = wheels.glob("*.whl")
    subprocess.run([*pip, "--python", str(python), "install", "--no-deps", str(wheel)], check=True)
    # The dependencies are those of this environment; a link in it to the checkout is not followed from a path file.
    (packages,) = (place / "lib").glob("python*/site-packages")
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return place / "bin", here


def _done(installed, program, *arguments):
    programs, here = installed
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "REPRO_PLUGINS")}
    environment |= {"REPRO_OUTPUTS": str(here / "outputs"), "OMP_NUM_THREADS": "1"}
    command = [str(programs / program), *arguments]
    return subprocess.run(command, cwd=here, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_fit_from_python_and_its_recording(installed):
    done = _done(installed, "python", "-c", FIT)
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()).is_relative_to(installed[0].parent)


@pytest.mark.slow
def test_commands_work_in_any_folder(installed):
    here = installed[1]
    made = _done(installed, "repro", *RUN)
    assert made.returncode == 0, made.stderr
    assert list((here / "outputs" / "recordings").glob("*/recording.rrd"))
    for command in (["run", "--help"], ["status"], ["runs"], ["report"], ["identify", "basis=t1", "scale=smoke"]):
        done = _done(installed, "repro", *command)
        assert done.returncode == 0, f"{command}: {done.stderr}"
        assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_every_other_command_works_or_is_one_line(installed):
    working = [["--help"], ["completion", "bash"], ["clean"]]
    working += [[name, "--help"] for name in ("reproduce", "sensitivity", "bench", "view", "export", "mlflow")]
    refused = [["view", "nothing"], ["export", "nothing", "there"], ["show", "nothing"], ["diff", "nothing", "else"]]
    for command in (*working, *refused):
        done = _done(installed, "repro", *command)
        assert done.returncode == (2 if command in refused else 0), f"{command}: {done.stderr}"
        assert len(done.stderr.splitlines()) == (1 if command in refused else 0), f"{command}: {done.stderr}"
