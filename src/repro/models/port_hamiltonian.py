"""Port-Hamiltonian models, eq. (5) with (10) and (11): passive for any weights, by construction (Theorem 1)."""

from collections.abc import Sequence

import casadi
import numpy as np

from repro.models.expression import ExpressionModel
from repro.models.features import FeatureMap
from repro.models.model import EnergyExpressions, Model, PortForm
from repro.models.model_options import Dissipation, NonNegative, Structure
from repro.models.momentum import MomentumTransform
from repro.models.port_matrices import Factored, Skew
from repro.models.position import PositionFeatures, cart_with_links


class PortHamiltonian(ExpressionModel):
    """xdot = (J - R) dH/dx + [0; tau] in x = [q; p], H the energy of another model and p = dL/dqd its momentum.

    structure `canonical`: J = [0 I; -I 0] and R = [0 0; 0 C]; `free`: J(x) = A - A' from a network; `full`: R(x) from
    networks too. C is 0, `constant`, or of the `state` q. `floor` adds floor/2 |qd/scale|^2 to T, so that M > 0, and H
    is bounded below wherever the model's own M >= 0 and V is bounded.

    An energy that is an interconnection of sub-systems brings their friction along, which must be linear in the rates:
    R_I is the sum of theirs, seen from the whole, and of the R learned here, as that of the joints between them.

    With `momentum_hidden` the momentum has a network of its own, p = M_hat(q) qd as in eq. (8), and so has the port
    form: H = qd' p / 2 + V. The objective of eq. (12) is then the loss of L (7a), Omega_tran, and both rows of (12b).
    parameters: [those of the energy | J | R | M_hat].
    """

    def __init__(
        self,
        energy: Model,
        velocity_scale: np.ndarray,
        *,
        structure: Structure = "canonical",
        dissipation: Dissipation = "state",
        hidden: Sequence[int] = (8,),
        non_negative: NonNegative = "softplus",
        floor: float = 0.0,
        momentum_hidden: Sequence[int] | None = None,
        positions: PositionFeatures | None = None,
    ) -> None:
        positions = positions or cart_with_links(energy.n_q)
        self.transforms = momentum_hidden is not None
        self.transform: MomentumTransform | None = None
        if momentum_hidden is not None:
            self.transform = MomentumTransform(energy.n_q, tuple(momentum_hidden), positions)
        self.energy, self.n_q, self.floor, self.structure = energy, energy.n_q, floor, structure
        self.fixed, self.upstream = energy.fixed, energy.upstream
        self.velocity_scale = np.asarray(velocity_scale, dtype=float)
        self.features = FeatureMap(positions.inertia, self.n_q)
        units, places = tuple(hidden), len(self.features)
        force_scale = tuple((1 / self.velocity_scale).tolist())
        scale = (*self.velocity_scale.tolist(), *force_scale)
        self.skew = None if structure == "canonical" else Skew(places + self.n_q, units, scale)
        if structure == "full":
            self.damping: Factored | None = Factored(places + self.n_q, units, scale, non_negative)
        elif dissipation == "none":
            self.damping = None
        else:
            self.damping = Factored(places, None if dissipation == "constant" else units, force_scale, non_negative)
        n_energy, n_skew, n_damping = (0 if part is None else part.n_parameters for part in self._parts)
        self.energy_slice = slice(0, n_energy)
        self.skew_slice = slice(n_energy, n_energy + n_skew)
        self.damping_slice = slice(n_energy + n_skew, n_energy + n_skew + n_damping)
        n_transform = 0 if self.transform is None else self.transform.network.n_parameters
        self.transform_slice = slice(self.damping_slice.stop, self.damping_slice.stop + n_transform)

    @property
    def n_parameters(self) -> int:
        """Number of weights of one member."""
        return self.transform_slice.stop

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """The start of every part."""
        parts = (*self._parts, self.transform)
        return np.concatenate([part.initial(generators) for part in parts if part is not None], axis=1)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T with its floor, and V."""
        energies = self.energy.energies(q, qd, parameters[self.energy_slice])
        least = 0.5 * self.floor * casadi.sumsqr(qd / casadi.DM(self.velocity_scale))
        return EnergyExpressions(energies.kinetic + least, energies.potential)

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """What eq. (12b) adds to the forces of L: C qd where J is canonical."""
        form = self.port_form(q, qd, parameters)
        return -form.gradient[: self.n_q] - form.drift[self.n_q :]

    def port_form(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> PortForm:
        """dH/dx and (J - R) dH/dx."""
        energies = self.energies(q, qd, parameters)
        kinetic = energies.kinetic
        if self.transform is not None:
            kinetic = 0.5 * casadi.dot(qd, self.transformed_momentum(q, qd, parameters))
        gradient = casadi.vertcat(casadi.gradient(energies.potential - kinetic, q), qd)
        return PortForm(gradient, self.structure_matrix(q, qd, parameters) @ gradient)

    def structure_matrix(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """J - R, (2 n_q, 2 n_q)."""
        return self.interconnection(q, qd, parameters) - self.resistance(q, qd, parameters)

    def interconnection(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """J, eq. (10)."""
        if self.skew is None:
            zero, identity = casadi.SX(self.n_q, self.n_q), casadi.SX.eye(self.n_q)
            return casadi.vertcat(casadi.horzcat(zero, identity), casadi.horzcat(-identity, zero))
        return self.skew.matrix(self._state(q, qd), parameters[self.skew_slice])

    def resistance(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """R, eq. (11), with the friction of the energy's own sub-systems."""
        zero = casadi.SX(self.n_q, self.n_q)
        rates = casadi.SX.sym("rates", self.n_q)
        friction = self.energy.friction(q, rates, parameters[self.energy_slice])
        shares = casadi.substitute(casadi.jacobian(friction, rates), rates, casadi.SX.zeros(self.n_q))
        parts = casadi.diagcat(zero, shares)
        if self.damping is None:
            return parts
        if self.structure == "full":
            return parts + self.damping.matrix(self._state(q, qd), parameters[self.damping_slice])
        return parts + casadi.diagcat(zero, self.damping.matrix(self._place(q, qd), parameters[self.damping_slice]))

    def part_energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> list[EnergyExpressions]:
        """Those of the energy, where it is an interconnection."""
        return self.energy.part_energies(q, qd, parameters[self.energy_slice])

    def transformed_momentum(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """M_hat(q) qd, eq. (8)."""
        if self.transform is None:
            return super().transformed_momentum(q, qd, parameters)
        return self.transform.expression(q, qd, parameters[self.transform_slice])

    def port_error(
        self, q: casadi.SX, qd: casadi.SX, qdd: casadi.SX, tau: casadi.SX, parameters: casadi.SX
    ) -> casadi.SX:
        """The error of (12b), (2 n_q,); with a momentum of its own, that of (7a) beside it, (3 n_q,)."""
        if self.transform is None:
            return super().port_error(q, qd, qdd, tau, parameters)
        momentum = self.transformed_momentum(q, qd, parameters)
        rate = casadi.jtimes(momentum, q, qd) + casadi.jtimes(momentum, qd, qdd)
        motion = self.port_form(q, qd, parameters).drift + casadi.vertcat(casadi.SX.zeros(self.n_q), tau)
        inverse = self.inverse_dynamics(q, qd, qdd, parameters) - tau
        return casadi.vertcat(inverse, motion - casadi.vertcat(qd, rate))

    @property
    def _parts(self) -> tuple[Model, Skew | None, Factored | None]:
        return self.energy, self.skew, self.damping

    def _place(self, q: casadi.SX, qd: casadi.SX) -> casadi.SX:
        return self.features.expression(q, qd)

    def _state(self, q: casadi.SX, qd: casadi.SX) -> casadi.SX:
        """x for a network: the position, and the velocities in their own scale in place of p."""
        return casadi.vertcat(self._place(q, qd), qd / casadi.DM(self.velocity_scale))
