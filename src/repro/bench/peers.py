"""Public peers on the same data and machine, each through its own package; those not installed are left out."""

from collections.abc import Iterator
from functools import partial
from importlib.metadata import PackageNotFoundError, version

from repro.bench.comparison import Comparison
from repro.bench.contender import PREPARED, STEP, Contender, compared, fastest, size_text, t2_case
from repro.bench.jax_peer import jax_step
from repro.bench.scale import PAPERS, Scale

JAX = "; JAX {version}, jit and vmap over samples and members, XLA with one thread"


def peers(scale: Scale) -> Iterator[Comparison]:
    """Steps of the inverse model against JAX: the LNN as published, and our own formulation."""
    found = _version("jax")
    if found is None:
        return
    ways = [
        Contender("JAX, LNN (Hessian and solve)", partial(jax_step, equation="forward")),
        Contender("JAX, inverse (jvp of grad)", partial(jax_step, equation="inverse")),
    ]
    for hidden, members in [*((hidden, 1) for hidden in scale.sizes), (PAPERS, scale.ensemble)]:
        case, protocol = t2_case(hidden, members, scale.batch), STEP.format(batch=scale.batch) + PREPARED
        for other in ways:
            pair = fastest("inverse"), other
            text = protocol + JAX.format(version=found)
            yield compared(scale, "peers", size_text(hidden), case, pair, text, members)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
