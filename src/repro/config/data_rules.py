"""Rules of the data: sensors, objectives without accelerations, and recordings of the user with their files."""

from collections.abc import Iterator
from dataclasses import replace

from repro.config.schema import Config, true_system
from repro.data.data_options import RandomForce, RecordingFile
from repro.errors import UserError


def without_accelerations(config: Config) -> Iterator[str]:
    """Objectives that need no accelerations: what they fit, and from which data."""
    objective, data = config.objective, config.data
    choice = f"objective.kind = '{objective.kind}'"
    if objective.needs_accelerations:
        return
    if config.sequence.needs_energies:
        yield f"{choice}: has no rows of a known energy; use sequence=main, not {config.sequence.kind}"
    if config.device != "cpu":
        yield f"{choice}: is computed on the processor; use device=cpu"
    if getattr(config.model, "structure", "canonical") != "canonical":
        yield f"{choice}: needs a momentum balance of its own; use model.structure=canonical"
    if not objective.is_likelihood:
        return
    if data.labels != "smoothed":
        yield f"{choice}: fits what sensors recorded, from a smoothed path; use data.labels=smoothed, not {data.labels}"
    if config.optimiser.selects:
        yield f"{choice}: keeps every term; use optimiser=least_squares, not {config.optimiser.name}"
    if objective.momentum_weight or any((objective.l1_kinetic, objective.l1_potential)):
        yield f"{choice}: is a likelihood; leave momentum_weight, l1_kinetic and l1_potential at 0"


def sensors(config: Config) -> Iterator[str]:
    """What is recorded of a simulated motion."""
    if isinstance(config.data, RandomForce):
        yield from config.data.problems()


def recording(config: Config) -> Iterator[str]:
    """What does not go with a recording."""
    if not isinstance(config.data, RecordingFile):
        return
    try:
        config.data.coordinates.described()
    except UserError as error:
        yield str(error)
        return
    if config.data.path == "???":
        yield "data.path: a value is needed: your CSV or Parquet file"
    elif missing := [str(path) for path in (*config.data.paths, *config.data.test_paths) if not path.exists()]:
        yield f"data.path = {missing[0]!r}: no such file; give a CSV or Parquet file, or a folder of them"
    if config.model.from_true_system:
        yield f"model.kind = {config.model.kind!r}: is made from the true system, which data=file does not include"
    if config.sequence.needs_energies:
        yield f"sequence.kind = '{config.sequence.kind}': needs simulated data; data=file goes with sequence=main"
    if config.curriculum.episodes:
        yield "curriculum.episodes: needs simulated data; data=file goes with curriculum=none"


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
