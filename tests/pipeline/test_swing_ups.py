"""The experiment swing_up at a smaller size: shares of loops that reach their goal."""

from pathlib import Path

import pandas as pd
import pytest

from repro.config.compose import compose
from repro.config.overrides import expand
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.store import Store

STARTS = 20
LEAST = {  # share of loops, of the true and of a learned model
    "torque_pendulum": 0.98, "furuta": 0.98, "pendubot": 0.94, "acrobot": 0.90, "quadrotor": 0.95, "dip": 0.90,
}  # fmt: skip
ADAPTIVE = 0.85  # of a learned model under mismatch, or of little accuracy, that is re-identified online
SLOWEST = 15.0  # ms of CPU time, 95th percentile of the steps of the median loop


def _least(words: list[str]) -> float:
    chosen = dict(word.split("=", 1) for word in words)
    if chosen.get("control.adaptive") == "True":
        return ADAPTIVE
    hard = "control.adaptive" in chosen or "task.noise" in chosen
    return 0.0 if hard else LEAST[chosen["system"]]


JOBS = [job for job in expand(["experiment=swing_up"]) if "control=none" not in job]


@pytest.mark.slow
@pytest.mark.parametrize("job", JOBS, ids=lambda job: "-".join(word.rpartition("=")[2] for word in job[:-1]))
def test_loops_reach_their_goal(job, tmp_path):
    store = Store(Path(tmp_path))
    pipeline = Pipeline.of(compose([*job, "scale=paper", f"task.initial_states={STARTS}"]).config, "")
    execute(pipeline, store)
    loops = pd.read_parquet(store.find(pipeline.control_stage.id, kind="control").path("control.parquet"))
    found = {"success": int(loops.success.sum()), "p95": float(loops.solve_ms_p95.median())}
    print(found)
    assert found["success"] >= _least(job) * STARTS - 1 and found["p95"] < SLOWEST, found
