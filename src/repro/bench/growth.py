"""How time and memory grow with the number of samples, far beyond memory, and with the number of members."""

from collections.abc import Iterator
from functools import partial
from itertools import pairwise

import numpy as np

from repro.bench.comparison import PairedComparison
from repro.bench.contender import STEP, Contender, compared, fastest, size_text, t2_case
from repro.bench.memory import peak_mib
from repro.bench.pairing import Pairs, Rounds, interleaved
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import EPISODE_STEPS, pendulum
from repro.learning.least_squares import regression
from repro.learning.objective import Objective
from repro.learning.streaming import streamed_solve
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import t1
from repro.models.lagrangian import Lagrangian

BLOCK = 100_000
SAMPLES = (
    "processor time of simulating the single pendulum in episodes of {steps} steps and of least squares for T1/V1, "
    "by blocks of {block} samples, none of which is stored; one thread; the ratio is the growth of the time; "
    "{{pairs}} pairs"
)
MEMBERS = "; compiled where there is a compiler; the ratio is the growth of the time of all members"


def samples(scale: BenchScale) -> Iterator[PairedComparison]:
    """Streamed least squares: from each number of samples to the next."""
    protocol = SAMPLES.format(steps=EPISODE_STEPS, block=BLOCK)
    rounds = Rounds(least=1, most=scale.rounds.most, limit_s=scale.rounds.limit_s)
    sizes = [*scale.streamed]
    for less, more in pairwise([sizes[0], *sizes]):

        def measure(less: int = less, more: int = more) -> Pairs:
            small, large = partial(streamed, less), partial(streamed, more)
            return interleaved(small, large, rounds).with_memory(peak_mib(small), peak_mib(large))

        yield PairedComparison("samples", f"{less:g} samples", f"{more:g} samples", "T1/V1", 1, protocol, measure)


def streamed(samples: int) -> np.ndarray:
    """The coefficients (4,) of T1/V1 from `samples` samples, simulated and used block by block."""
    model = Lagrangian(t1, 2)

    def blocks() -> Iterator[tuple[np.ndarray, np.ndarray]]:
        for number, start in enumerate(range(0, samples, BLOCK)):
            dataset = pendulum([number], min(BLOCK, samples - start))
            problem = TrainingProblem(model, [make_task(model, dataset, Objective())], [number])
            yield regression(problem, model.n_parameters)

    return streamed_solve(blocks(), 1e-12)[0]


def members(scale: BenchScale) -> Iterator[PairedComparison]:
    """Ensembles: one member against many, each with a batch of its own."""
    batch = scale.many_batch
    for number in scale.many:
        one = Contender("1 member", fastest("inverse").step)
        many = Contender(f"{number} members", fastest("inverse").step, t2_case(PAPER_HIDDEN, number, batch))
        case, protocol = t2_case(PAPER_HIDDEN, 1, batch), STEP.format(batch=batch) + MEMBERS
        yield compared(scale, "members", size_text(PAPER_HIDDEN), case, (one, many), protocol)
