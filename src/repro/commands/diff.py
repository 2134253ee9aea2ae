"""`repro diff`: how two stored stages differ."""

import json
from collections.abc import Sequence
from dataclasses import asdict

from repro.commands.arguments import ID, add_json, command_parser
from repro.tracking.load import load_record
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.stage_difference import Difference, record_differences
from repro.tracking.store import Store
from repro.tracking.text import short, table

_LINE = 100  # characters of a difference whose two sides are printed on one line


def main(argv: Sequence[str]) -> int:
    """Print the differences of two stored stages, by area."""
    description = "How two stored stages differ: settings, code, libraries, origin, results, and those of their inputs."
    parser = command_parser("diff", description, "example: repro diff 9f3c2a81bd 04be7d1f6a")
    parser.add_argument("before", help=ID)
    parser.add_argument("after", help=ID)
    add_json(parser)
    arguments = parser.parse_args(argv)
    paths = Paths(outputs_root())
    before, after = load_record(paths, arguments.before), load_record(paths, arguments.after)
    differences = record_differences(Store(paths.root), before, after)
    if arguments.json:
        print(json.dumps([asdict(one) for one in differences], indent=1))
        return 0
    for area in dict.fromkeys(one.area for one in differences):
        print(area)
        own = [one for one in differences if one.area == area]
        for one in filter(_is_long, own):
            print(f"  {one.key}\n    {one.before}\n    {one.after}")
        # of code, only that it changed
        brief = [
            [f"  {one}"] if area.endswith("code") else [f"  {one.key}", short(one.before), "->", short(one.after)]
            for one in own
            if not _is_long(one)
        ]
        if brief:
            print(table(brief))
    if not differences:
        print("They do not differ.")
    return 0


def _is_long(one: Difference) -> bool:
    """Whether the two sides read better below each other."""
    return not one.area.endswith("code") and len(f"{one.key}{one.before}{one.after}") > _LINE
