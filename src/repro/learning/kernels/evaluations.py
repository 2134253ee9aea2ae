"""How often the code of a fit would run: whether compiling it takes less time than it saves."""

import math
from dataclasses import dataclass

# What compiled code saves of torch's time, on one core: of each call, and of each sample and weight in it.
CALL_S = 3e-3
SAMPLE_AND_WEIGHT_S = 5e-8


@dataclass(frozen=True)
class Evaluations:
    """Of a loss and its derivatives by one process: about how many, on how many samples each."""

    count: float
    samples: float

    def seconds_saved(self, n_parameters: int) -> float:
        """What compiled code would save, the compiler's time not counted."""
        return self.count * (CALL_S + self.samples * n_parameters * SAMPLE_AND_WEIGHT_S)


ENDLESS = Evaluations(math.inf, math.inf)  # compile wherever it is possible
