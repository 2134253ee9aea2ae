"""How the weights of a model are fitted."""

from dataclasses import dataclass

from repro.learning.objective_options import ObjectiveOptions
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.sequence_options import SequenceOptions
from repro.plugins.options import Options


@dataclass(frozen=True)
class Training(Options):
    """Objective, sequence of data, optimiser, and the device (`cpu` or `cuda`)."""

    objective: ObjectiveOptions
    sequence: SequenceOptions
    optimiser: OptimiserOptions
    device: str = "cpu"
