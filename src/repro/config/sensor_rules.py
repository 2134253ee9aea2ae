"""Rules of data without accelerations: which sensors there can be, and which objectives use them."""

from collections.abc import Iterator

from repro.config.schema import Config
from repro.data.data_options import RandomForce


def without_accelerations(config: Config) -> Iterator[str]:
    """Objectives that need no accelerations: what they fit, and from which data."""
    objective, data = config.objective, config.data
    choice = f"objective.kind = '{objective.kind}'"
    if not config.model.fitted or objective.needs_accelerations:
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
    data = config.data
    if not isinstance(data, RandomForce):
        return
    if data.measured != "accelerations" and data.labels == "exact":
        yield f"data.labels = 'exact': data.measured={data.measured} has no accelerations; use data.labels=smoothed"
    if len(data.quantisation) not in (0, 2):
        yield f"data.quantisation = {list(data.quantisation)}: two steps, of lengths (m) and of angles (rad), or none"
    ratio = data.time_step / (data.sample_step or data.time_step)
    if ratio < 1 or abs(ratio - round(ratio)) > 1e-6:
        yield f"data.sample_step = {data.sample_step}: data.time_step = {data.time_step} s is no whole multiple of it"
