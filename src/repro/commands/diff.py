"""`repro diff`: how two stored stages differ."""

import json
from argparse import Namespace
from dataclasses import asdict

from repro.tracking.load import load_stage
from repro.tracking.paths import outputs_root
from repro.tracking.stage_difference import record_differences
from repro.tracking.store import Store
from repro.tracking.text import short, table

_LINE = 100  # characters of a difference whose two sides are printed on one line


def main(arguments: Namespace) -> int:
    """Print the differences of two stored stages, by area."""
    before, after = load_stage(arguments.before), load_stage(arguments.after)
    differences = record_differences(Store(outputs_root()), before, after)
    if arguments.json:
        print(json.dumps([asdict(one) for one in differences], indent=1))
        return 0
    for area in dict.fromkeys(one.area for one in differences):
        print(area)
        brief = []
        for one in (one for one in differences if one.area == area):
            if area.endswith("code"):
                brief.append([f"  {one}"])  # only that it changed
            elif len(f"{one.key}{one.before}{one.after}") > _LINE:
                print(f"  {one.key}\n    {one.before}\n    {one.after}")
            else:
                brief.append([f"  {one.key}", short(one.before), "->", short(one.after)])
        print(table(brief), end="\n" if brief else "")
    if not differences:
        print("They do not differ.")
    return 0
