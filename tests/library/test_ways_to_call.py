"""Fits and recordings from Python, in whatever kind of process a user runs them."""

import os
import subprocess
import sys
import textwrap

import pytest

FIT = """
import repro
def fitted_error():
    data = repro.simulate("sip", samples=200, reset="random", episode_steps=20)
    fitted = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares", system=repro.system("sip"))
    fitted.record("fit.rrd")
    return float(fitted.score().loc["mae_tau", 0])
"""
WAYS = {
    "unguarded script": "print(fitted_error())",
    "asyncio": """
        import asyncio
        async def main():
            return await asyncio.gather(asyncio.to_thread(fitted_error), asyncio.sleep(0))
        print(asyncio.run(main())[0])
        """,
    "spawned process": """
        if __name__ == "__main__":
            import multiprocessing
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                print(pool.apply(fitted_error))
        """,
    "pickled": """
        import pickle
        data = repro.simulate("sip", samples=200, reset="random", episode_steps=20)
        fitted = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares", system=repro.system("sip"))
        print(pickle.loads(pickle.dumps(fitted)).score().loc["mae_tau", 0])
        """,
}


@pytest.mark.slow
@pytest.mark.parametrize("way", [*WAYS, "stdin"])
def test_a_fit_works_in_any_kind_of_process(way, tmp_path):
    program = FIT + textwrap.dedent(WAYS.get(way, WAYS["unguarded script"]))
    script = tmp_path / "script.py"
    script.write_text(program)
    given = (
        {"args": [sys.executable, "-"], "input": program} if way == "stdin" else {"args": [sys.executable, script.name]}
    )
    done = subprocess.run(
        given["args"], input=given.get("input"), cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.splitlines()[-1]) < 1e-9
    assert not done.stderr


def test_importing_it_loads_nothing_heavy():
    heavy = {"numpy", "torch", "casadi", "pandas", "rerun", "hydra", "pydantic"}
    program = f"import sys, repro; print(sorted({heavy} & {{*sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
