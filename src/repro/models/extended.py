"""A trained sub-model inside a larger one: H_I = H_S + H_R, H_R of all coordinates (section IV, Proposition 1)."""

from typing import Literal

from repro.errors import UserError
from repro.models.interconnection import Interconnection, Joined
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.network import Activation
from repro.models.setting import Setting
from repro.models.structured import Structured


def build(
    setting: Setting,
    *,
    parts: list[str],
    frozen: bool = True,
    rest: Literal["structured", "basis"] = "structured",
    hidden: list[int],
    rank: int | None = None,
    activation: Activation = "tanh",
    skip: bool = True,
) -> Interconnection:
    """The model of this file for a setting; the keywords are its options in conf/model.

    The one part is of the first coordinates, as a cart with one rod is of a double pendulum; UserError otherwise.
    """
    if len(setting.parts) != 1 or setting.parts[0].model.n_q >= setting.n_q:
        raise UserError(f"model.parts = {parts}: give one sub-model of fewer coordinates than {setting.n_q}")
    (part,) = setting.parts
    own = part.model.n_q
    other: Model
    if rest == "basis":
        other = Lagrangian(setting.basis, setting.n_q, hidden=hidden, activation=activation)
    else:
        other = Structured(
            setting.n_q, setting.velocity_scale, hidden=hidden, rank=rank, activation=activation, skip=skip
        )
    joined = [Joined(part.model, lambda q: q[:own]), Joined(other, lambda q: q)]
    return Interconnection(joined, setting.n_q, part.parameters, frozen)
