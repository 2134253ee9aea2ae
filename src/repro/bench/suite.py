"""All comparisons: the rivals of claim C11, the usual way of computing, public peers, and how costs grow."""

from repro.bench.engines import coordinates, engines, members, samples
from repro.bench.neural_ode import paths
from repro.bench.pairing import PairedComparison
from repro.bench.peers import peers
from repro.bench.rivals import steps_of_rivals, time_to_accuracy
from repro.bench.scale import SCALES


def comparisons(scale: str) -> list[PairedComparison]:
    """All comparisons of a scale, not measured yet; peers that are not installed are left out."""
    chosen = SCALES[scale]
    parts = (steps_of_rivals, time_to_accuracy, paths, engines, peers, coordinates, members, samples)
    return [comparison for part in parts for comparison in part(chosen)]
