"""`repro view`: opens the recording of a run, or of several beside one plant."""

from argparse import Namespace

from repro.recording import viewer
from repro.tracking.paths import outputs_root


def main(arguments: Namespace) -> int:
    """Run `repro view`; raises UserError when the recording is missing, ambiguous or cannot be shown here."""
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
