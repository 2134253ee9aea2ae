"""`repro clean`: removes leftovers, never a current result."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from repro.errors import UserError
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.text import size


def clean(argv: Sequence[str]) -> int:
    """`repro clean`: remove leftovers; shows first, removes with --yes."""
    from repro.tracking import leftovers as cleaning

    parser = argparse.ArgumentParser(
        prog="repro clean",
        description="List what can go without losing a current result; with --yes, remove it.",
        epilog="example: repro clean stale --yes",
    )
    parser.add_argument(
        "sorts", nargs="*", metavar="what", help=f"{', '.join(cleaning.SORTS)} (default: all but stale)"
    )
    parser.add_argument("--yes", action="store_true", help="remove them")
    options = parser.parse_args(argv)
    for sort in options.sorts:
        if sort not in cleaning.SORTS:
            raise UserError(f"clean knows no {sort}; choose from {', '.join(cleaning.SORTS)}")
    paths = Paths(outputs_root())
    folders = cleaning.removable(paths, options.sorts or cleaning.USUAL)
    sizes = {folder: cleaning.size_of(folder) for folder in folders}
    gone = list(cleaning.remove(paths, folders)) if options.yes else folders
    for folder in gone:
        print(f"{size(sizes[folder]):>10}  {folder.relative_to(paths.root)}")
    total = size(sum(sizes[folder] for folder in gone))
    print(
        f"{total} removed." if options.yes else f"{total} can be removed: add --yes." if gone else "Nothing to remove."
    )
    return 0
