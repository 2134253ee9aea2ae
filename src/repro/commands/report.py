"""`repro report`: gather, judge, draw; redraw from results; publish."""

from argparse import Namespace

from repro.commands import runs
from repro.launch import own_progress
from repro.recording.viewer import find_recording
from repro.report import build, terminal
from repro.results.results import Results
from repro.results.stored import stale_runs
from repro.tracking.paths import Paths, outputs_root, project_folder


def main(arguments: Namespace) -> int:
    """Run `repro report`. Raises UserError for a mistake of the user."""
    outputs = outputs_root()
    recordings = [find_recording(run, outputs) for run in arguments.interactive]
    try:
        with own_progress.shown("report"):
            if arguments.source is not None:
                summary = build.redraw(arguments.source, outputs / "report" / "redrawn")
            else:
                summary = build.build(outputs, arguments.scale, stale=stale_runs(outputs))
    except build.NothingToJudgeError as error:
        if arguments.publish or not Paths(outputs).ids("runs"):
            raise
        # those that belong to no experiment, since there is nothing to judge
        runs.main(Namespace(kind="runs", filters=[], json=False))
        print(f"\n{error}")
        return 0
    terminal.show(summary)
    page = summary.page
    if recordings:
        from repro.report.html.interactive import write_interactive

        page = write_interactive(recordings, summary.folder)
        print(page)
    if arguments.publish:
        from repro.report.publish import publish

        publish(Results.load(arguments.source or summary.results), project_folder())
        print("published: paper/results, paper/tables, paper/figures, README.md; look at them, then commit")
    if arguments.open:
        import webbrowser

        webbrowser.open(page.absolute().as_uri())
    return 0
