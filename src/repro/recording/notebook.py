"""A recording inside a notebook, in the viewer's own widget."""

from pathlib import Path

from rerun import RecordingStream
from rerun.notebook import HAS_NOTEBOOK, Viewer

from repro.errors import UserError
from repro.recording.writer import APPLICATION

WIDTH, HEIGHT = 960, 540  # pixels


def show(recording: Path | str, *, width: int = WIDTH, height: int = HEIGHT) -> object:
    """A recording as the result of a cell: the viewer's window inside the page.

    Parameters
    ----------
    recording
        The `.rrd` file that `FittedModel.record` or a run has written.
    width, height
        Of the window, pixels.

    Returns
    -------
    rerun.notebook.Viewer
        A widget that the notebook displays.

    Raises
    ------
    UserError
        For a file that is not there, and without the extra `notebook`, which brings the viewer's widget.
    """
    path = Path(recording)
    if not path.is_file():
        raise UserError(f"show: no file {path}")
    if not HAS_NOTEBOOK:
        raise UserError(
            f"show: the viewer's widget is missing (pip install 'repro[notebook]'); or open it with: repro view {path}"
        )
    stream = RecordingStream(APPLICATION)
    viewer = Viewer(width=width, height=height, recording=stream)
    stream.log_file_from_path(path)
    return viewer
