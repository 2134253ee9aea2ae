"""Public peers on the same data and machine, each through its own package; those not installed are left out."""

from collections.abc import Callable, Iterator
from functools import partial
from importlib.metadata import PackageNotFoundError, version

from repro.bench.contender import PREPARED, Contender, compared, fastest
from repro.bench.control import control
from repro.bench.framework_peers import jax_batched_step, jax_step, torch_compiled_step
from repro.bench.package_peers import phlearn_step, selection_fit, sindy_pi_fit
from repro.bench.pairing import PairedComparison, Pairs, with_memory
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import Precision, Step
from repro.codegen.c_library import has_compiler

BATCHED = "; batched, one tangent forward and one pass back written out, derivatives of the features prepared for both"
JAX = "; JAX {version}, jit and vmap over samples and members, XLA with one thread"
PHLEARN = "; phlearn {version}: a pseudo-Hamiltonian network of equal width, loss on the rates of the state"
PYSINDY = (
    "processor time of finding the single pendulum's equation from {batch} samples, candidates prepared beforehand; "
    "one thread; in turn, {{pairs}} pairs; pysindy {version}: both accelerations, l1 weight 1e-4, which leaves an "
    "error of qdd below 1e-6; ours has the terms and coefficients of L to rounding"
)
WIDE = (64, 64)


def peers(scale: BenchScale) -> Iterator[PairedComparison]:
    """Comparisons with torch.compile and with the installed packages."""
    if scale.compile_torch and has_compiler():
        yield from _batched(scale, "torch.compile", torch_compiled_step)
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
        for other in ways:
            remark = PREPARED + JAX.format(version=version)
            yield compared(scale, "peers", hidden, fastest("inverse"), other, remark, members=members)
    yield from _batched(scale, f"JAX {version}, jit", jax_batched_step)


def _batched(scale: BenchScale, label: str, step: Callable[..., Step]) -> Iterator[PairedComparison]:
    """One network in both precisions against the strongest form that a framework can be given."""
    precisions: tuple[Precision, ...] = ("float64", "float32")
    for hidden in (scale.sizes[0], scale.sizes[-1]):
        for precision in precisions:
            other = Contender(f"{label}, batched, {precision}", partial(step, precision=precision))
            ours = fastest("inverse", precision)
            yield compared(scale, "peers", hidden, ours, other, BATCHED, precision=precision)


def _phlearn(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    other, remark = Contender("phlearn, network for H", phlearn_step), PREPARED + PHLEARN.format(version=version)
    yield compared(scale, "peers", WIDE, fastest("inverse", "float32"), other, remark, precision="float32")


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
