"""`repro status`: what is done, stale, failed or missing, and why."""

import json
from argparse import Namespace
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

from repro.config.places import digest
from repro.errors import UserError
from repro.tracking.load import matching
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.stage import Stage
from repro.tracking.survey import STATES, Item, survey
from repro.tracking.text import short, table

_MOST_LINES = 15


def main(arguments: Namespace) -> int:
    """Print the state of every stage, or with --why ID what changed in the inputs of one."""
    paths = Paths(outputs_root())
    items = survey(paths, verify=arguments.verify, expected=_expected, settings=digest)
    if arguments.why:
        fitting = matching([item.id for item in items], arguments.why)
        if not fitting:
            raise UserError(f"no stage {arguments.why} is stored or listed; `repro status --all` names them")
        items = [item for item in items if item.id in fitting]
    if arguments.json:
        print(json.dumps([asdict(item) for item in items], indent=1))
    elif arguments.why:
        for item in items:
            command = [f"made by: {item.command}"] if item.command else []
            print(f"{item.id}: {item.state}", *(f"  {line}" for line in (*item.why, *command)), sep="\n")
    else:
        _print_status(items, paths, arguments.all)
    return 0


def _expected(overrides: Sequence[str]) -> Sequence[Stage]:
    """The stages of a job, composed again: slow, so done only for experiments whose settings have changed."""
    from repro.sweep.missing import expected_stages

    return list(expected_stages(overrides))


def _print_status(items: Sequence[Item], paths: Paths, everything: bool) -> None:
    if not items:
        print(f"Nothing in {paths.root} yet; `repro reproduce` fills it.")
        return
    counts = Counter((item.kind, item.state) for item in items)
    kinds = sorted({item.kind for item in items})
    shown = [state for state in STATES if any(counts[kind, state] for kind in kinds)]
    print(table([[kind, *(counts[kind, state] or "-" for state in shown)] for kind in kinds], ["", *shown]))
    for state in shown:
        chosen = [item for item in items if item.state == state]
        if state == "done" and not everything:
            continue
        lines = chosen if everything else chosen[:_MOST_LINES]
        print(f"\n{state}")
        print(table([f"  {item.id}", short(item.why[0].partition("\n")[0], 100) if item.why else ""] for item in lines))
        if len(lines) < len(chosen):
            print(f"  ... and {len(chosen) - len(lines)} more (--all)")
