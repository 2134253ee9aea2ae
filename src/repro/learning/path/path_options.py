"""Options of objective=path."""

from dataclasses import dataclass
from typing import Literal

from repro.plugins.options import Count, NotNegative, Options, Positive


@dataclass(frozen=True)
class PathOptions(Options):
    """Options of the maximum likelihood of weights and motion together.

    window: s of motion with a start of its own. substeps: of a sampling interval; None: by the fastest rate in the
    data. noise: of the sensors, `given` with the data or `estimated` from the residuals, which takes several rounds.
    process: standard deviations of unknown accelerations (m/s^2, rad/s^2) in successive stages; None: 0, after 1 and
    0.1 where the model is no linear basis. initial: standard deviations of positions (m, rad) and velocities at the
    start of a window. iterations: of each stage, at most. zeros: whether the encoders of `angles` have an unknown zero
    each, which is estimated too; the weights are then those of the true angles.
    """

    window: Positive = 2.0
    substeps: Count | None = None
    noise: Literal["given", "estimated"] = "given"
    process: tuple[NotNegative, ...] | None = None
    initial: tuple[Positive, Positive] = (1.0, 30.0)
    iterations: Count = 60
    zeros: Literal["none", "angles"] = "none"
