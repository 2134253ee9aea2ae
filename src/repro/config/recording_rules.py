"""What a recording of the user goes with, and what is wrong in its files."""

from collections.abc import Iterator
from dataclasses import replace

from repro.config.schema import Config, true_system
from repro.data.data_options import RecordingFile
from repro.errors import UserError


def recording(config: Config) -> Iterator[str]:
    """What does not go with a recording."""
    if not isinstance(config.data, RecordingFile):
        return
    if config.data.path == "???":
        yield "data.path: a value is needed: your CSV or Parquet file"
    elif wrong := _coordinates_problem(config.data):
        yield wrong
    elif missing := [str(path) for path in (*config.data.paths, *config.data.test_paths) if not path.exists()]:
        yield f"data.path = {missing[0]!r}: no such file; give a CSV or Parquet file, or a folder of them"
    if config.model.from_true_system:
        yield f"model.kind = {config.model.kind!r}: is made from the true system, which data=file does not include"
    if config.sequence.needs_energies:
        yield f"sequence.kind = '{config.sequence.kind}': needs simulated data; data=file goes with sequence=main"
    if config.curriculum.episodes:
        yield "curriculum.episodes: needs simulated data; data=file goes with curriculum=none"


def _coordinates_problem(source: RecordingFile) -> str:
    try:
        source.coordinates.described()
    except UserError as error:
        return str(error)
    return ""


def wrong_content(config: Config) -> Iterator[str]:
    """What is wrong in the files of a recording, which are read for it."""
    if not isinstance(config.data, RecordingFile):
        return
    from repro.data.recording_file import from_file

    try:
        unsmoothed = replace(config.data, labels="recorded")
        train = from_file(unsmoothed, None if config.own_coordinates else true_system(config)).train
    except UserError as error:
        yield str(error)
        return
    learned = config.model.fitted and not config.model.from_true_system
    if learned and not train.tau.any() and config.objective.needs_force:
        yield (
            f"objective.kind = '{config.objective.kind}': no force acts in {train.provenance['file']}, and L = 0 "
            "explains that too; use objective=forward, or name the columns of the force (data.columns.tau)"
        )
