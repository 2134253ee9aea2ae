"""How the weights of a model are fitted."""

from dataclasses import dataclass
from typing import Annotated

from repro.learning.objective_options import OBJECTIVES, ObjectiveOptions
from repro.learning.optimiser_options import OPTIMISERS, OptimiserOptions
from repro.learning.sequence_options import SEQUENCES, SequenceOptions
from repro.plugins.checked import chosen
from repro.plugins.options import Options


@dataclass(frozen=True)
class Training(Options):
    """Objective, sequence of data, optimiser, and the device (`cpu` or `cuda`)."""

    objective: Annotated[ObjectiveOptions, *chosen("objective", OBJECTIVES)]
    sequence: Annotated[SequenceOptions, *chosen("sequence", SEQUENCES)]
    optimiser: Annotated[OptimiserOptions, *chosen("optimiser", OPTIMISERS)]
    device: str = "cpu"
