"""`repro export`: one member of a learned model, as files that need nothing of this project."""

from argparse import Namespace

from repro.errors import UserError
from repro.export.member import LearnedMember, write
from repro.pipeline.finished_run import OpenedRun, load_run


def main(arguments: Namespace) -> int:
    """Write the learned functions of one member and print the names of the files."""
    run = load_run(arguments.run)
    if not isinstance(run, OpenedRun):
        raise UserError(f"{run.id} is no run but one of {run.kind}: `repro runs` lists the runs")
    statuses, seed = run.card["member_status"], arguments.member
    if seed is not None and seed not in run.seeds:
        raise UserError(f"--member {seed}: {run.id} has the seeds {', '.join(map(str, run.seeds))}")
    member = run.seeds.index(seed) if seed is not None else statuses.index("ok") if "ok" in statuses else 0
    exported = LearnedMember(
        run=run.id,
        seed=run.seeds[member],
        system=run.card["system"],
        command=run.provenance.command,
        card=run.card,
        model=run.model,
        weights=run.parameters[member].numpy(),
        coordinates=run.data.coordinates,
    )
    for name in write(exported, arguments.folder):
        print(arguments.folder / name)
    return 0
