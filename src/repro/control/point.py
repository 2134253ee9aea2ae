"""One point of the horizon: what it costs and which margins it keeps, with derivatives as scalar functions."""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca


@dataclass(frozen=True)
class Point:
    """Expressions in variables z (n_z,), parameters of all points, and data of the interval that begins here.

    Its functions, every result one column:

    value  (z, shared, data) -> [cost | margins]
    slope  (z, shared, data) -> [cost | margins | d cost/dz | d margins/dz by rows]
    curve  (z, shared, data, multipliers) -> d2(multipliers . [cost | margins])/dz2, all n_z^2 entries
    """

    name: str
    variables: ca.SX
    shared: ca.SX
    data: ca.SX
    cost: ca.SX
    margins: ca.SX

    @cached_property
    def value(self) -> ca.Function:
        """Cost and margins."""
        return self._function("value", [self.cost, self.margins])

    @cached_property
    def slope(self) -> ca.Function:
        """Cost and margins with their derivatives."""
        gradient = ca.gradient(self.cost, self.variables)
        slopes = ca.vec(ca.jacobian(self.margins, self.variables).T)
        return self._function("slope", [self.cost, self.margins, gradient, slopes])

    @cached_property
    def curve(self) -> ca.Function:
        """The Hessian of a combination of cost and margins."""
        both = ca.vertcat(self.cost, self.margins)
        multipliers = ca.SX.sym("lambda", both.numel())
        hessian = ca.hessian(ca.dot(multipliers, both), self.variables)[0]
        return self._function("curve", [ca.vec(hessian)], multipliers)

    def _function(self, what: str, results: list[ca.SX], *further: ca.SX) -> ca.Function:
        given = [self.variables, self.shared, self.data, *further]
        columns = ca.vertcat(*(ca.densify(result) for result in results))
        return ca.Function(f"{self.name}_{what}", given, [columns], {"cse": True})
