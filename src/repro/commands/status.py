"""The light commands of the front door: status, runs, clean."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

from repro.errors import UserError
from repro.tracking import status as states
from repro.tracking.ids import matching
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.stage import Stage
from repro.tracking.text import short, table

_MOST_LINES = 15


def status(argv: Sequence[str]) -> int:
    """`repro status`: what is done, stale, failed, missing, running; --why ID names what changed."""
    parser = argparse.ArgumentParser(
        prog="repro status",
        description="What is done, stale (code, libraries or defaults changed), failed, missing, running, interrupted.",
        epilog="example: repro status --why sip-lagrangian-t2-9f3c2a81bd",
    )
    parser.add_argument("--why", metavar="ID", help="name every input of this stage that changed (the id may be cut)")
    parser.add_argument("--all", action="store_true", help="list every stage, not the first few of each state")
    parser.add_argument("--json", action="store_true", help="for other programs")
    parser.add_argument(
        "--verify", action="store_true", help="read every byte of every result; move damaged ones aside"
    )
    options = parser.parse_args(argv)
    paths = Paths(outputs_root())
    items = _survey(paths, options.verify)
    if options.why:
        items = _chosen(items, options.why)
    if options.json:
        print(json.dumps([asdict(item) for item in items], indent=1))
    elif options.why:
        for item in items:
            print(f"{item.id}: {item.state}", *(f"  {line}" for line in item.why), sep="\n")
            print(*([f"  made by: {item.command}"] if item.command else []), sep="\n", end="\n" if item.command else "")
    else:
        _print_status(items, paths, options.all)
    return 0


def _survey(paths: Paths, verify: bool) -> list[states.Item]:
    """The survey; jobs are composed again, which loads the sweep, only where the settings have changed."""
    from repro.config.places import digest

    def expected(overrides: Sequence[str]) -> Sequence[Stage]:
        from repro.sweep.missing import expected_stages

        return list(expected_stages(overrides))

    return states.survey(paths, verify=verify, expected=expected, settings=digest)


def _chosen(items: Sequence[states.Item], text: str) -> list[states.Item]:
    fitting = matching([item.id for item in items], text)
    if not fitting:
        raise UserError(f"no stage {text} is stored or listed; `repro status --all` names them")
    return [item for item in items if item.id in fitting]


def _print_status(items: Sequence[states.Item], paths: Paths, everything: bool) -> None:
    if not items:
        print(f"Nothing in {paths.root} yet; `repro reproduce` fills it.")
        return
    counts = Counter((item.kind, item.state) for item in items)
    kinds = sorted({item.kind for item in items})
    shown = [state for state in states.STATES if any(counts[kind, state] for kind in kinds)]
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
