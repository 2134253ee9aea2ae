"""`repro clean`: removes leftovers, never a current result."""

from collections.abc import Sequence

from repro.commands.arguments import command_parser
from repro.errors import UserError
from repro.tracking import leftovers
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.text import size


def main(argv: Sequence[str]) -> int:
    """List the leftovers; remove them with --yes."""
    description = "List what can be removed without losing a current result; with --yes, remove it."
    parser = command_parser("clean", description, "example: repro clean stale --yes")
    sorts = ", ".join(leftovers.SORTS)
    parser.add_argument("sorts", nargs="*", metavar="what", help=f"{sorts} (default: all but stale)")
    parser.add_argument("--yes", action="store_true", help="remove them")
    arguments = parser.parse_args(argv)
    if unknown := [sort for sort in arguments.sorts if sort not in leftovers.SORTS]:
        raise UserError(f"repro clean: there is no {unknown[0]} to remove; choose from {sorts}")
    paths = Paths(outputs_root())
    folders = leftovers.removable(paths, arguments.sorts or leftovers.USUAL)
    sizes = {folder: leftovers.size_of(folder) for folder in folders}
    shown = list(leftovers.remove(paths, folders)) if arguments.yes else folders
    for folder in shown:
        print(f"{size(sizes[folder]):>10}  {folder.relative_to(paths.root)}")
    total = size(sum(sizes[folder] for folder in shown))
    if arguments.yes:
        print(f"{total} removed.")
    else:
        print(f"{total} can be removed: add --yes." if shown else "Nothing to remove.")
    return 0
