"""T = qd' M(q) qd / 2 with M(q) = C C' positive semi-definite by construction, V in cosines or a network."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.models.model_options import Activation, Damping, Factor, Initialisation, ModelOptions
from repro.plugins.options import Count, NotNegative

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=structured.

    hidden: units of each hidden layer of C. factor: a `wide` C of `rank` columns (None: n_q + 2), or a `triangular`
    one, the Cholesky factor of M. skip: a linear path beside the hidden layers. scaled: velocities are divided by their
    spread in the data, so that M starts at the data's inertia scale. initialisation `inertia`: M starts as the
    identity, in those units. potential: V linear in `cosines` (and translations), or a `network` of potential_hidden
    layers, or one more output of the network of C (`shared`); `auto` takes the cosines where each is an angle from the
    vertical, as on a cart with links. floor: of the eigenvalues of M, in the scale of the velocities.
    """

    runs_on_device: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (8,)
    factor: Factor = "wide"
    rank: Count | None = None
    activation: Activation = "tanh"
    skip: bool = True
    scaled: bool = True
    initialisation: Initialisation = "inertia"
    potential: Literal["auto", "cosines", "network", "shared"] = "auto"
    potential_hidden: tuple[Count, ...] = (16,)
    damping: Damping = "none"
    floor: NotNegative = 0.0

    def problems(self) -> Iterator[str]:
        """A triangular factor has no rank to choose."""
        if self.rank is not None and self.factor == "triangular":
            yield (
                f"model.rank = {self.rank}: a triangular factor has as many columns as coordinates; use "
                "model.factor=wide"
            )

    def device_problem(self) -> str | None:
        """A triangular factor is not computed by torch."""
        return "model.factor=triangular" if self.factor == "triangular" else None


def build(context: Context, options: Options) -> Model:
    """The model, beside friction where chosen."""
    import numpy as np

    from repro.models.damped import with_damping
    from repro.models.structured import Structured

    cosines = options.potential == "cosines" or (options.potential == "auto" and context.positions.upright_angles)
    model = Structured(
        context.n_q,
        context.velocity_scale if options.scaled else np.ones(context.n_q),
        hidden=options.hidden,
        rank=options.rank,
        activation=options.activation,
        skip=options.skip,
        factor=options.factor,
        initialisation=options.initialisation,
        potential_hidden=None if cosines or options.potential == "shared" else options.potential_hidden,
        potential_shared=options.potential == "shared",
        floor=options.floor,
        positions=context.positions,
    )
    return with_damping(model, options.damping, context.positions)
