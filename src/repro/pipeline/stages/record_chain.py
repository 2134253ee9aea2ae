"""A recording of the learned chain in motion beside the true one."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from repro.evaluation.chains import KEPT, TIME_STEP, Motion, random_start, simulate_chain
from repro.models.ports import ChainLink
from repro.pipeline.stage_options import RecordingOptions
from repro.pipeline.stages.stored_fit import load_parameters, model_of, simulated_system
from repro.recording.chain_writer import ChainMotion, ChainRecording, write_chain_recording
from repro.recording.contents import FILENAME
from repro.tracking.load import Run

SPACING = 1.0  # m from mass to mass at rest, in the picture


def make(folder: Path, options: RecordingOptions, run: Run, command: str) -> dict[str, int]:
    """Record the chain of a stored run."""
    summary, fit = run.record.summary, run.upstream["fit"]
    card = {**summary["card"], "test medians": summary["median"], "command": command}
    model, weights = model_of(options.fit, fit.upstream), load_parameters(fit.record.folder)
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
    recording = ChainRecording(*described, time, _drawn(plant), {f"seed {seed}": _drawn(learned)})
    write_chain_recording(folder / FILENAME, recording)
    return {"member": seed, "links": links}


def _drawn(motion: Motion) -> ChainMotion:
    links = motion.states.shape[1] // 2
    rest = SPACING * np.arange(1, links + 1)
    return ChainMotion(rest + np.cumsum(motion.states[:, :links], axis=1), motion.energy)
