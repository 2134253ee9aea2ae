"""The wheel, installed elsewhere: a fit with its recording, a report, and the list of choices, in any folder."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RUN = ["run", "basis=t1", "optimiser=least_squares", "scale=smoke", "seeds=1"]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder with the installed package, and one to work in."""
    place, here = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("wörk (1)")
    wheels = tmp_path_factory.mktemp("wheels")
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", str(wheels), str(ROOT)], check=True)
    (wheel,) = wheels.glob("*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--target", str(place), str(wheel)], check=True)
    return place, here


def _repro(installed, *arguments):
    place, here = installed
    environment = {**os.environ, "PYTHONPATH": str(place), "REPRO_OUTPUTS": str(here / "outputs")}
    program = [sys.executable, "-m", "repro", *arguments]
    return subprocess.run(program, cwd=here, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_wheel_works_in_any_folder(installed):
    place, here = installed
    where = subprocess.run(
        [sys.executable, "-c", "import repro; print(repro.__file__)"], cwd=here, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(place)}, check=True,
    )  # fmt: skip
    assert where.stdout.startswith(str(place))
    made = _repro(installed, *RUN)
    assert made.returncode == 0, made.stderr
    assert list((here / "outputs" / "recordings").glob("*/recording.rrd"))
    for command in (["run", "--help"], ["status"], ["runs"], ["report"], ["identify", "basis=t1", "scale=smoke"]):
        done = _repro(installed, *command)
        assert done.returncode == 0, f"{command}: {done.stderr}"
        assert "Traceback" not in done.stderr
