"""`repro sensitivity`: each assumption changed by itself, on few members, to see which verdicts it moves."""

from argparse import Namespace
from collections.abc import Sequence

from repro.claims.assumption_effects import assumption_effects, gather_sensitivity
from repro.claims.assumptions import load_assumptions
from repro.claims.claims import Claim, load_claims
from repro.errors import UserError
from repro.launch.pool import start_server
from repro.results.gather import Gathering
from repro.results.results import SENSITIVITY
from repro.results.stored import read_stored
from repro.sweep.assumption_runs import list_cases, plan_cases
from repro.sweep.missing import preload, run_missing
from repro.sweep.planned_job import total
from repro.tracking.paths import Paths, outputs_root, project_folder


def main(arguments: Namespace) -> int:
    """Run what the assumptions' trials need, and list it for the report; 1 when a job failed."""
    paper, paths = project_folder() / "paper", Paths(outputs_root())
    claims, ledger = load_claims(paper / "claims.yaml"), load_assumptions(paper / "assumptions.yaml")
    ids = [row.id for row in ledger]
    if unknown := [name for name in arguments.assumptions if name not in ids]:
        raise UserError(f"no assumption is called {', '.join(unknown)}; there are {', '.join(ids)}")
    chosen = [row for row in ledger if not arguments.assumptions or row.id in arguments.assumptions]
    if not arguments.dry_run:
        start_server(preload([()]))
    cases, jobs = plan_cases(chosen, claims, paths)
    if arguments.dry_run:
        print("\n".join(dict.fromkeys(f"{case.assumption}, {case.claim}: {case.alternative}" for case in cases)))
        print(total(jobs))
        return 0
    list_cases(paths, cases, jobs, tried={row.id for row in chosen})
    results = run_missing(jobs, paths, arguments.workers)
    _show(paths, claims, [row.id for row in chosen])
    return 1 if any(not result.ok for result in results) else 0


def _show(paths: Paths, claims: Sequence[Claim], tried: Sequence[str]) -> None:
    from repro.report.terminal import show_sensitivity  # after the runs: their start must not wait for it

    tried_runs, paper = read_stored(paths.root, SENSITIVITY), Gathering.load(project_folder() / "paper")
    sensitivity = gather_sensitivity(tried_runs, paper)
    if sensitivity is not None:
        effects = [effect for effect in assumption_effects(sensitivity, claims) if effect.assumption in tried]
        show_sensitivity(sorted(effects, key=lambda effect: tried.index(effect.assumption)))
