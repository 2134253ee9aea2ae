"""The schema of a closed loop: the controller (conf/control) and what is asked of it (conf/task)."""

from typing import Annotated, Literal

from pydantic import Field

from repro.config.base import Count, NotNegative, Positive, Section


class NoControl(Section):
    """No closed loop (conf/control/none)."""

    name: str
    kind: Literal["none"]


class NodeWeights(Section):
    """What one node of the horizon costs: weights of T, V_cost, (x - x_des)^2, the angle error, |qd|^2 and f^2."""

    kinetic: NotNegative
    potential: NotNegative
    position: NotNegative
    angle: NotNegative
    rates: NotNegative
    force: NotNegative


class Predictive(Section):
    """Problem (9) and how it is solved."""

    name: str
    kind: Literal["mpc"]
    intervals: Count
    time_step: Positive
    coarse_intervals: Annotated[int, Field(ge=0)]
    coarse_step: Positive
    stage_cost: NodeWeights
    terminal_cost: NodeWeights
    angle_error: Literal["cosine", "square"]
    force_limit: Positive
    speed_limit: Positive | None
    clearance_radii: Positive
    obstacle_constraint: bool
    obstacle_weight: Positive
    midpoints: bool
    discretisation: Literal["shooting", "collocation"]
    solver: Literal["fatrop", "ipopt"]
    tolerance: Positive
    iterations: Count
    seconds: Positive
    adaptive: bool
    prior_error: Positive
    prior_friction: Positive
    noise: Positive
    drift: Positive


class EnergyShaping(Section):
    """The classical swing-up."""

    name: str
    kind: Literal["energy_shaping"]
    time_step: Positive
    force_limit: Positive


class Task(Section):
    """Where a closed loop starts, where it should go, and what disturbs it (conf/task)."""

    name: str
    start: Literal["hanging", "random"]
    initial_states: Count
    start_seed: Annotated[int, Field(ge=0)]
    x_des: Annotated[list[float], Field(min_length=1)]
    seconds: Annotated[float, Field(ge=2, le=1000)]
    centre: Annotated[list[float], Field(min_length=2, max_length=2)]
    radius: NotNegative | None
    mismatch: Annotated[float, Field(ge=0, lt=1)]
    mismatch_kind: Literal["coefficients", "physical"]
    noise: NotNegative
    disturbance: NotNegative
    delay: NotNegative
    damping: list[NotNegative]


Control = Annotated[NoControl | Predictive | EnergyShaping, Field(discriminator="kind")]
