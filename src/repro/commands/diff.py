"""`repro diff`: how two stored stages differ."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from repro.commands.arguments import stored_record
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.text import short, table

if TYPE_CHECKING:
    from repro.tracking.stage_difference import Difference


_LINE = 100


def diff(argv: Sequence[str]) -> int:
    """`repro diff A B`: how two stages differ."""
    parser = argparse.ArgumentParser(
        prog="repro diff",
        description="How two stored stages differ: settings, code, libraries, origin, results, and their sources' too.",
        epilog="example: repro diff 9f3c2a81bd 04be7d1f6a",
    )
    parser.add_argument("before", help="an id, its start, or the digits at its end")
    parser.add_argument("after")
    parser.add_argument("--json", action="store_true", help="for other programs")
    options = parser.parse_args(argv)
    from repro.tracking.stage_difference import record_differences
    from repro.tracking.store import Store

    paths = Paths(outputs_root())
    found = record_differences(
        Store(paths.root), stored_record(paths, options.before), stored_record(paths, options.after)
    )
    if options.json:
        print(json.dumps([asdict(one) for one in found], indent=1))
        return 0
    for area in dict.fromkeys(one.area for one in found):
        print(area)
        own = [one for one in found if one.area == area]
        for one in filter(_is_long, own):
            print(f"  {one.key}\n    {one.before}\n    {one.after}")
        if brief := [_sides(one) for one in own if not _is_long(one)]:
            print(table(brief))
    if not found:
        print("They do not differ.")
    return 0


def _is_long(one: Difference) -> bool:
    """Whether the two sides read better below each other."""
    return not one.area.endswith("code") and len(f"{one.key}{one.before}{one.after}") > _LINE


def _sides(one: Difference) -> list[str]:
    """What differs, before and after; of code there is no more to say than that it changed."""
    if one.area.endswith("code"):
        return [f"  {one}"]
    return [f"  {one.key}", short(one.before), "->", short(one.after)]
