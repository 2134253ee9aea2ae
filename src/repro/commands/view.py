"""`repro view`: opens the recording of a run, or of several beside one plant."""

from collections.abc import Sequence
from pathlib import Path

from repro.commands.arguments import command_parser
from repro.recording import viewer
from repro.tracking.paths import outputs_root


def main(argv: Sequence[str]) -> int:
    """Run `repro view`; raises UserError when the recording is missing, ambiguous or cannot be shown here."""
    parser = command_parser("view")
    parser.add_argument(
        "run", nargs="+", help="id of a run, its beginning or last digits, or the path of an .rrd file; or several ids"
    )
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--web", action="store_true", help="serve it to a browser instead of opening a window")
    way.add_argument("--screenshot", metavar="FILE", type=Path, help="write a PNG picture; needs no display")
    parser.add_argument("--at", metavar="SECONDS", type=float, help="moment in the picture (default: the middle)")
    arguments = parser.parse_args(argv)
    if len(arguments.run) == 1:
        path = viewer.find_recording(arguments.run[0], outputs_root())
    else:
        from repro.pipeline.side_by_side import compared

        path = compared(arguments.run)
    if arguments.screenshot:
        viewer.screenshot(path, arguments.screenshot, arguments.at)
        print(arguments.screenshot)
        return 0
    return viewer.serve(path) if arguments.web else viewer.open_window(path)
