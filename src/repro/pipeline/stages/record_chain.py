"""A recording of the learned chain in motion beside the true one."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from repro.evaluation.chains import KEPT, TIME_STEP, Motion, random_start, simulate_chain
from repro.mechanics.system import System
from repro.models.model import Model
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
    seeds, system = options.fit.seeds, simulated_system(options.fit)
    return record(folder, run.id, options.title, card, model, weights, seeds, system, options.links)


def record(
    folder: Path,
    run: str,
    title: str,
    card: Mapping[str, object],
    model: Model,
    parameters: np.ndarray,
    seeds: Sequence[int],
    system: System,
    links: int,
) -> dict[str, int]:
    """Write recording.rrd: 10 s of free motion of the true chain and of that of the first member."""
    start = random_start(links)
    plant = simulate_chain(ChainLink.true(system), start)
    learned = simulate_chain(ChainLink.learned(model, parameters[0]), start)
    time = np.arange(len(plant.energy)) * KEPT * TIME_STEP
    models = {f"seed {seeds[0]}": _drawn(learned)}
    write_chain_recording(folder / FILENAME, ChainRecording(run, title, card, time, _drawn(plant), models))
    return {"member": int(seeds[0]), "links": links}


def _drawn(motion: Motion) -> ChainMotion:
    links = motion.states.shape[1] // 2
    rest = SPACING * np.arange(1, links + 1)
    return ChainMotion(rest + np.cumsum(motion.states[:, :links], axis=1), motion.energy)
