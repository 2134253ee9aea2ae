"""A recording of the learned chain in motion beside the true one."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from repro.evaluation.chains import KEPT, TIME_STEP, Motion, random_start, simulate_chain
from repro.models.ports import ChainLink
from repro.pipeline.stage_options import RecordingOptions
from repro.pipeline.stages.stored_fit import load_parameters, model_of, simulated_system
from repro.recording.contents import FILENAME, DrawnMotion, DrawnShape, RunRecording
from repro.recording.writer import write_recording
from repro.tracking.record import Record

SPACING = 1.0  # m from mass to mass at rest, in the picture
MASS = 0.12  # m, radius of a mass in the picture
ABOVE = 0.4  # m that the learned chain is above the true one in the picture


def make(folder: Path, options: RecordingOptions, upstream: Mapping[str, Record]) -> dict[str, int]:
    """Record the chain of a stored run."""
    run = upstream["run"]
    summary, fit = run.summary, run.upstream["fit"]
    card = {**summary["card"], "test medians": summary["median"], "command": run.provenance.command}
    model, weights = model_of(options.fit, fit.upstream), load_parameters(fit.folder)
    assert options.links is not None
    both = ChainLink.true(simulated_system(options.fit)), ChainLink.learned(model, weights[0])
    return record(folder, (run.id, options.title, card), both, options.fit.seeds[0], options.links)


def record(
    folder: Path, described: tuple[str, str, Mapping[str, object]], both: Sequence[ChainLink], seed: int, links: int
) -> dict[str, int]:
    """Write recording.rrd: 10 s of free motion of chains of the true and of a learned link.

    described: the run's id, title and card.
    """
    plant, learned = (simulate_chain(link, random_start(links)) for link in both)
    time = np.arange(len(plant.energy)) * KEPT * TIME_STEP
    models = {f"seed {seed}": _drawn(learned, ABOVE)}
    recording = RunRecording(*described, time, [], _drawn(plant, 0.0), models, forces={}, power={})
    write_recording(folder / FILENAME, recording)
    return {"member": seed, "links": links}


def _drawn(motion: Motion, height: float) -> DrawnMotion:
    """Springs as one line from the wall at 0 through all masses."""
    steps, links = len(motion.states), motion.states.shape[1] // 2
    places = SPACING * np.arange(links + 1) + np.cumsum(np.pad(motion.states[:, :links], ((0, 0), (1, 0))), axis=1)
    points = np.stack([places, np.full_like(places, height)], axis=-1)
    shapes = [DrawnShape("link", points), DrawnShape("disc", points[:, 1:], size=(MASS, MASS))]
    return DrawnMotion(np.zeros((steps, 0)), {"H": motion.energy}, shapes)
