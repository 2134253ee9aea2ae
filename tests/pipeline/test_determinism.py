"""The same run gives the same bits; on another number of threads it agrees within a stated tolerance.

Jobs of a sweep run on one thread, so that their results do not depend on the number of cores. The fits here are given
threads on purpose: where torch splits a sum over threads it adds in another order, which it does for wide networks
alone. Measured: equal bits for the small fits; for networks of 2 x 64 units weights within 8e-14 and metrics within
2e-8, the worst where accelerations divide by a mass matrix that is close to singular.
"""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch
from threadpoolctl import threadpool_limits

from repro.config.compose import compose
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.load import load_stage
from repro.tracking.store import Store

# relative: of every weight to the largest one, and of every metric
SMALL_TOLERANCES = {"weights": 1e-9, "metrics": 1e-9}
WIDE_TOLERANCES = {"weights": 1e-11, "metrics": 1e-6}
SMALL = {
    "generated code": "scale=smoke data.samples=200 basis=t2 optimiser=adam",
    "torch": "scale=smoke data.samples=200 basis=t2 optimiser=adam optimiser.engine=torch",
    "Levenberg-Marquardt": "scale=smoke data.samples=200 basis=t2 optimiser=levenberg_marquardt",
}
WIDE = (
    "scale=quick seeds=1 basis=t2 model.hidden=[64,64] optimiser=adam optimiser.engine=torch optimiser.epochs=20",
    "scale=quick seeds=1 basis=t2 objective=forward model.hidden=[64,64] optimiser=lbfgs optimiser.iterations=10",
)
IN_A_FRESH_PROCESS = "import sys, test_determinism as t; print(*t.execute_all(t.Path(sys.argv[1]), sys.argv[2:], 1))"

Results = dict[str, tuple[np.ndarray, dict[str, pd.DataFrame]]]


def execute_all(root: Path, runs: Sequence[str], threads: int) -> list[str]:
    """The ids of runs (overrides), made in a store on so many threads."""
    before = torch.get_num_threads()
    torch.set_num_threads(threads)
    try:
        with threadpool_limits(threads):
            composed = [compose([*run.split(), "record=false"]) for run in runs]
            return [execute(Pipeline.of(each.config, each.command), Store(root)).id for each in composed]
    finally:
        torch.set_num_threads(before)


def results(root: Path, runs: Sequence[str], ids: Sequence[str]) -> Results:
    """Overrides -> (weights, tables of the run)."""
    found: Results = {}
    for run, id in zip(runs, ids, strict=True):
        tables = {path.stem: pd.read_parquet(path) for path in (root / "runs" / id).glob("*.parquet")}
        metrics = tables["metrics"]
        tables["metrics"] = metrics[metrics["metric"] != "fit_seconds"]
        fit = load_stage(id, root=root).upstream["fit"]
        with np.load(fit.path("parameters.npz")) as stored:
            found[run] = (stored["parameters"], tables)
    return found


def made(root: Path, runs: Sequence[str], threads: int = 1) -> Results:
    return results(root, runs, execute_all(root, runs, threads))


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return made(tmp_path_factory.mktemp("once"), list(SMALL.values()))


@pytest.fixture(scope="module")
def again(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """By a fresh process, in which the hashes of texts differ."""
    root, runs = tmp_path_factory.mktemp("again"), list(SMALL.values())
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": "1"}
    command = [sys.executable, "-c", IN_A_FRESH_PROCESS, str(root), *runs]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return results(root, runs, done.stdout.split())


@pytest.fixture(scope="module")
def on_two_threads(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return made(tmp_path_factory.mktemp("threads"), list(SMALL.values()), threads=2)


@pytest.mark.parametrize("run", SMALL.values(), ids=SMALL)
def test_the_same_run_gives_the_same_bits(run: str, once: Results, again: Results) -> None:
    weights, tables = once[run]
    np.testing.assert_array_equal(weights, again[run][0], strict=True)
    assert {"metrics", "curves"} <= set(tables)
    for name, table in tables.items():
        pd.testing.assert_frame_equal(table, again[run][1][name], check_exact=True)


@pytest.mark.parametrize("run", SMALL.values(), ids=SMALL)
def test_the_number_of_threads_does_not_matter(run: str, once: Results, on_two_threads: Results) -> None:
    assert_close(once[run], on_two_threads[run], **SMALL_TOLERANCES)


@pytest.mark.slow
def test_the_number_of_threads_hardly_matters_to_wide_networks(tmp_path: Path) -> None:
    one, two = made(tmp_path / "one", WIDE), made(tmp_path / "two", WIDE, threads=2)
    for run in WIDE:
        assert_close(one[run], two[run], **WIDE_TOLERANCES)


def assert_close(
    one: tuple[np.ndarray, dict[str, pd.DataFrame]],
    two: tuple[np.ndarray, dict[str, pd.DataFrame]],
    *,
    weights: float,
    metrics: float,
) -> None:
    np.testing.assert_allclose(one[0], two[0], rtol=0, atol=weights * np.abs(one[0]).max())
    first, second = one[1]["metrics"], two[1]["metrics"]
    assert list(first["metric"]) == list(second["metric"])
    np.testing.assert_allclose(first["value"], second["value"], rtol=metrics, atol=0)
