"""A learned Lagrangian beside friction that is linear in its coefficients: viscous, dry, and constant forces."""

from collections.abc import Sequence
from dataclasses import replace

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.mechanics.coordinate import joint_rates
from repro.mechanics.system import SLIDING
from repro.models.model import EnergyExpressions, Model, Prepared, consecutive
from repro.models.model_options import Damping
from repro.models.position import PositionFeatures, cart_with_links
from repro.models.terms import Terms


class Damped(Model):
    """tau = d/dt(dL/dqd) - dL/dq + C qd + ... with a constant C = sum_k c_k E_k.

    `diagonal`: one coefficient per joint, on relative rates, so that E_k = e e' with e qd the rate of joint k, see
    `joint_rates`; `full`: one coefficient per entry of a symmetric C; `gyroscopic`: beside the diagonal ones an
    antisymmetric matrix, as between a current and a rotor, which exchange power without loss. (Any matrix would leave
    the scale of the energies open where a coordinate has no input.) `coulomb`: beside the diagonal ones a dry friction
    per joint, e' v / sqrt(v^2 + SLIDING^2) for the rate v = e qd; `offset`: beside these a constant force per
    coordinate. No sign is imposed. positions: a cart with links by default.
    parameters: [those of the model | c | dry | constant].
    """

    def __init__(self, model: Model, damping: Damping, positions: PositionFeatures | None = None) -> None:
        self.model, self.n_q = model, model.n_q
        jointed = (positions or cart_with_links(model.n_q)).jointed
        self.shapes = paired(model.n_q, 1) if damping == "full" else diagonal(model.n_q, jointed)
        if damping == "gyroscopic":
            self.shapes = np.concatenate([self.shapes, paired(model.n_q, -1)])
        self.rates = joint_rates(model.n_q, jointed) if damping in ("coulomb", "offset") else np.zeros((0, model.n_q))
        self.constant = np.eye(model.n_q) if damping == "offset" else np.zeros((model.n_q, 0))
        counts = {"c": len(self.shapes), "dry": len(self.rates), "offset": self.constant.shape[1]}
        self.names = tuple(f"{name}{index}" for name, count in counts.items() for index in range(count))
        self.linear_in_weights = model.linear_in_weights
        self.inverse, self.energetic = model.inverse, model.energetic
        self.transform, self.transform_slice = model.transform, model.transform_slice
        self.model_slice, self.damping_slice = consecutive(model.n_parameters, len(self.names))
        self.n_parameters = self.damping_slice.stop

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of the model's coefficients, then c0, c1, ..., dry0, ..., offset0, ..."""
        return (*self.model.coefficient_names, *self.names)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """The model's start, without friction."""
        return np.pad(self.model.initial(generators), ((0, 0), (0, len(self.names))))

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """What the model needs, and the columns of friction (..., n_q, n_coefficients)."""
        columns = np.einsum("kcd,...d->...ck", self.shapes, qd)
        if len(self.names) > len(self.shapes):
            rate = qd @ self.rates.T
            dry = self.rates.T * (rate / np.sqrt(rate**2 + SLIDING**2))[..., None, :]
            constant = np.broadcast_to(self.constant, (*qd.shape, self.constant.shape[1]))
            columns = np.concatenate([columns, dry, constant], axis=-1)
        return self.model.prepare(q, qd, qdd, tau) | {"damping": columns}

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """The model's outputs, and the friction (member, sample, n_q)."""
        outputs = self.model.outputs(parameters[:, self.model_slice], prepared, mass)
        friction = torch.einsum("mnck,mk->mnc", prepared["damping"], parameters[:, self.damping_slice])
        return [*outputs, friction]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """The model's terms, with friction in tau."""
        terms = self.model.terms(outputs[:-1], prepared)
        return replace(terms, tau=terms.tau + outputs[-1])

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        model = self.model.vjp(parameters[:, self.model_slice], prepared, cotangents[:-1])
        return torch.cat([model, torch.einsum("mrnc,mnck->mrnk", cotangents[-1], prepared["damping"])], dim=-1)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """The model's T and V."""
        return self.model.energies(q, qd, parameters[self.model_slice])

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """C qd, and what else there is."""
        own, viscous = parameters[self.damping_slice], len(self.shapes)
        coefficients = casadi.vertsplit(own[:viscous])
        matrix = sum(c * casadi.DM(shape) for c, shape in zip(coefficients, self.shapes, strict=True))
        force = matrix @ qd
        if len(self.names) > viscous:
            rates, dry = casadi.DM(self.rates), own[viscous : viscous + len(self.rates)]
            rate = rates @ qd
            force += rates.T @ (dry * rate / casadi.sqrt(rate**2 + SLIDING**2))
            force += casadi.DM(self.constant) @ own[viscous + len(self.rates) :]
        return force


def with_damping(model: Model, damping: Damping, positions: PositionFeatures) -> Model:
    """The model itself, or beside friction."""
    return model if damping == "none" else Damped(model, damping, positions)


def without_damping(model: Model) -> Model:
    """The model within."""
    return model.model if isinstance(model, Damped) else model


def diagonal(n_q: int, jointed: Sequence[int]) -> np.ndarray:
    """Shapes E_k (n_q, n_q, n_q) of the matrix of a viscous friction in every joint."""
    rates = joint_rates(n_q, jointed)
    shapes: np.ndarray = np.einsum("ki,kj->kij", rates, rates)
    return shapes


def paired(n_q: int, sign: int) -> np.ndarray:
    """Shapes E_k of a symmetric (sign 1) or antisymmetric (-1) matrix (n_q, n_q), upper entries in row order."""
    rows, columns = np.triu_indices(n_q, 0 if sign == 1 else 1)
    shapes = np.zeros((len(rows), n_q, n_q))
    numbers = np.arange(len(rows))
    shapes[numbers, columns, rows] = sign
    shapes[numbers, rows, columns] = 1
    return shapes
