"""A node of the horizon: its cost and its inequality constraints, with derivatives as scalar functions."""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca


@dataclass(frozen=True)
class Node:
    """Expressions in variables z (n_z,), parameters shared by all nodes, and data of the interval that begins here.

    cost     J, scalar
    margins  (n_margins,) of which each must not be negative

    Its functions, each with one column as its result:

    value     (z, shared, data) -> [cost | margins]
    jacobian  (z, shared, data) -> [cost | margins | d cost/dz | d margins/dz by rows]
    hessian   (z, shared, data, multipliers) -> d2(multipliers . [cost | margins])/dz2, all n_z^2 entries
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
    def jacobian(self) -> ca.Function:
        """Cost and margins with their first derivatives."""
        gradient = ca.gradient(self.cost, self.variables)
        rows = ca.vec(ca.jacobian(self.margins, self.variables).T)
        return self._function("jacobian", [self.cost, self.margins, gradient, rows])

    @cached_property
    def hessian(self) -> ca.Function:
        """The Hessian of a combination of cost and margins."""
        both = ca.vertcat(self.cost, self.margins)
        multipliers = ca.SX.sym("lambda", both.numel())
        hessian = ca.hessian(ca.dot(multipliers, both), self.variables)[0]
        return self._function("hessian", [ca.vec(hessian)], multipliers)

    def _function(self, derivative: str, results: list[ca.SX], *further: ca.SX) -> ca.Function:
        inputs = [self.variables, self.shared, self.data, *further]
        column = ca.vertcat(*(ca.densify(result) for result in results))
        return ca.Function(f"{self.name}_{derivative}", inputs, [column], {"cse": True})
