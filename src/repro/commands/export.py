"""`repro export`: one member of a learned model, as files that need nothing of this project."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from repro.errors import UserError
from repro.pipeline.finished_run import OpenedRun, open_run
from repro.tracking.files import write_json, write_text

LARGEST = 2000  # weights: every one is a statement of the exported code


def main(argv: Sequence[str]) -> int:
    """`repro export RUN FOLDER`: write the learned functions of one member."""
    parser = argparse.ArgumentParser(
        prog="repro export",
        description="Write one member's T, V, L, H, p, M, inverse and forward dynamics as CasADi functions, C source "
        "and a torch module. What is written needs CasADi or torch, and nothing of this project.",
        epilog="example: repro export 9f3c2a81bd exported/",
    )
    parser.add_argument("run", help="the id of a run, its start or the digits at its end")
    parser.add_argument("folder", type=Path, help="a new or empty folder")
    parser.add_argument(
        "--member", type=int, metavar="SEED", help="the seed of the member (default: the first good one)"
    )
    options = parser.parse_args(argv)
    run = open_run(options.run)
    if not isinstance(run, OpenedRun):
        raise UserError(f"{run.id} is no run but one of {run.record.kind}: `repro runs` lists the runs")
    for name in export(run, options.folder, options.member):
        print(options.folder / name)
    return 0


def export(run: OpenedRun, folder: Path, seed: int | None = None) -> list[str]:
    """Write the files into a new or empty folder and return their names; UserError for what cannot be exported."""
    from repro.export import casadi_functions, torch_module

    member = _member(run, seed)
    weights = run.parameters[member].numpy()
    if not 0 < len(weights) <= LARGEST:
        raise UserError(f"{run.id} has {len(weights)} weights a member: from 1 to {LARGEST} can be exported")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder} is there already and not empty: choose a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    functions = casadi_functions.functions(run.model, weights)
    names = casadi_functions.write(folder, functions)
    names += torch_module.write(folder, run.model, weights, title=f"{run.id}, seed {run.seeds[member]}")
    about = {
        "run": run.id,
        "seed": run.seeds[member],
        "command": run.record.provenance.command,
        "coordinates": [{"name": c.name, "unit": c.unit, "is_angle": c.is_angle} for c in run.data.coordinates],
        "units": {"kinetic, potential, lagrangian, hamiltonian": "J", "inverse": "N, N m", "forward": "of qdd"},
        "gauge": "T and V as the model gives them: L is fixed only up to a constant and dF(q)/dt",
        "functions": {f.name(): [f.name_in(i) for i in range(f.n_in())] for f in functions},
        "card": run.card,
    }
    write_json(folder / "about.json", about)
    write_text(folder / "README.md", _read_me(run, names))
    return ["README.md", "about.json", *names]


def _member(run: OpenedRun, seed: int | None) -> int:
    if seed is None:
        return next((i for i, status in enumerate(run.card["member_status"]) if status == "ok"), 0)
    if seed not in run.seeds:
        raise UserError(f"--member {seed}: {run.id} has the seeds {', '.join(map(str, run.seeds))}")
    return run.seeds.index(seed)


def _read_me(run: OpenedRun, names: Sequence[str]) -> str:
    inputs = ", ".join(f"{c.name} in {c.unit}" for c in run.data.coordinates)
    return f"""# {run.id}

A learned model of `{run.card["system"]}`; q = ({inputs}), qd and qdd its rates, tau the generalised force.

CasADi (columns of {len(run.data.coordinates)}):

    forward = casadi.Function.load("forward.casadi")
    qdd = forward(q, qd, tau)

C: `model.c` and `model.h` hold the same functions; `cc -O2 -shared -fPIC model.c -o model.so -lm`, then for CasADi
`casadi.external("forward", "./model.so")`.

torch (any leading axes): `import model`, then the functions of model.py; the weights are in weights.npz.

Files: {", ".join(names)}. about.json says what was run, and what T and V mean.
"""
