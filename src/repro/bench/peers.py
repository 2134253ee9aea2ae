"""Public peers on the same data and machine, each through its own package; those not installed are left out."""

from collections.abc import Iterator
from functools import partial
from importlib.metadata import PackageNotFoundError, version

from repro.bench.contender import PREPARED, STEP, Contender, compared, fastest, t2_case
from repro.bench.control import control
from repro.bench.jax_peer import jax_step
from repro.bench.package_peers import phlearn_step, selection_fit, sindy_pi_fit
from repro.bench.pairing import PairedComparison, Pairs, with_memory
from repro.bench.scale import PAPER_HIDDEN, BenchScale

JAX = "; JAX {version}, jit and vmap over samples and members, XLA with one thread"
PHLEARN = "; phlearn {version}: a pseudo-Hamiltonian network of equal width in float32, loss on the rates of the state"
PYSINDY = (
    "processor time of finding the single pendulum's equation from {batch} samples, candidates prepared beforehand; "
    "one thread; in turn, {{pairs}} pairs; pysindy {version}: both accelerations, l1 weight 1e-4, which leaves an "
    "error of qdd below 1e-6; ours has the terms and coefficients of L to rounding"
)
WIDE = (64, 64)


def peers(scale: BenchScale) -> Iterator[PairedComparison]:
    """Comparisons with the installed packages."""
    for package, compare in PEERS.items():
        if installed := _version(package):
            yield from compare(scale, installed)


def missing() -> list[str]:
    """Names of the packages that are not installed."""
    return [package for package in PEERS if _version(package) is None]


def _jax(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    """Steps of the inverse model against the LNN as published, and against our own formulation."""
    ways = [
        Contender("JAX, LNN (Hessian and solve)", partial(jax_step, equation="forward")),
        Contender("JAX, inverse (jvp of grad)", partial(jax_step, equation="inverse")),
    ]
    for hidden, members in [*((hidden, 1) for hidden in scale.sizes), (PAPER_HIDDEN, scale.ensemble)]:
        case, protocol = t2_case(hidden, members, scale.batch), STEP.format(batch=scale.batch) + PREPARED
        for other in ways:
            text = protocol + JAX.format(version=version)
            yield compared(scale, "peers", hidden, case, (fastest("inverse"), other), text, members)


def _phlearn(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    pair = fastest("inverse"), Contender("phlearn, network for H", phlearn_step)
    protocol = STEP.format(batch=scale.batch) + PREPARED + PHLEARN.format(version=version)
    yield compared(scale, "peers", WIDE, t2_case(WIDE, 1, scale.batch), pair, protocol)


def _pysindy(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    def measure() -> Pairs:
        return with_memory(selection_fit(scale.batch), sindy_pi_fit(scale.batch), scale.rounds)

    protocol = PYSINDY.format(batch=scale.batch, version=version)
    labels = "thresholded least squares", "pysindy, SINDy-PI", "35 | 16 terms"
    yield PairedComparison("peers", *labels, 1, protocol, measure)


PEERS = {"jax": _jax, "phlearn": _phlearn, "pysindy": _pysindy, "do-mpc": control}


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
