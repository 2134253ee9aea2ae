"""`repro view`: opens the recording of a run, or of several beside one plant."""

from collections.abc import Sequence

from repro.commands.arguments import parsed
from repro.recording import viewer
from repro.tracking.paths import outputs_root


def main(argv: Sequence[str]) -> int:
    """Run `repro view`; raises UserError when the recording is missing, ambiguous or cannot be shown here."""
    arguments = parsed("view", argv)
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
