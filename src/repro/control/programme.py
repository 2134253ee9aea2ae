"""The nonlinear programme and its derivatives as CasADi functions, assembled from those of one stage.

The stage is differentiated once as scalar expressions and mapped over the horizon, so the functions stay small for any
horizon and compile in seconds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from repro.control.interval import Expression, Interval
from repro.control.transcription import Transcription


@dataclass(frozen=True)
class Programme:
    """Expressions in x, p and the multipliers lam_f (1,), lam_g, by the names by which CasADi's solvers look them up.

    gamma is the Lagrangian lam_f f + lam_g . g, and hess_gamma_x_x the whole symmetric Hessian.
    """

    inputs: Mapping[str, ca.MX]
    outputs: Mapping[str, ca.MX]

    def function(self, name: str, outputs: Sequence[str]) -> ca.Function:
        """A function of x and p, and of the multipliers for outputs of the Lagrangian."""
        dual = any("gamma" in output for output in outputs)
        inputs = ["x", "p", "lam_f", "lam_g"] if dual else ["x", "p"]
        columns = [self.outputs[output] for output in outputs]
        return ca.Function(name, [self.inputs[each] for each in inputs], columns, inputs, list(outputs))


def programme(of: Transcription) -> Programme:
    """The programme of a transcription."""
    n, n_x, n_w, n_rows = of.n_intervals, of.n_x, of.n_w, of.n_rows
    x, p = ca.MX.sym("x", of.n_variables), ca.MX.sym("p", of.n_parameters)
    lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", sum(of.rows))
    stages, last, shared = ca.reshape(x[: n * n_w], n_w, n), x[n * n_w :], p[n_x:]
    inputs = (stages, shared, ca.DM(of.data))
    each = _StageFunctions.of(of.interval, n)
    end = _StageFunctions.of(of.end)

    cost, own = each.value(*inputs)
    end_cost, end_margins = end.value(last, shared, ca.DM.zeros(2))
    following = ca.horzcat(stages[:n_x, 1:], last)
    rows = ca.vec(own + ca.vertcat(following, ca.MX(n_rows - n_x, n)))
    g = ca.vertcat(rows[:n_rows], x[:n_x] - p[:n_x], rows[n_rows:], end_margins)

    gradient, jacobian = each.jacobian(*inputs)
    end_gradient, end_jacobian = end.jacobian(last, shared, ca.DM.zeros(2))
    grad_f = ca.vertcat(ca.vec(gradient), end_gradient)
    ones = ca.DM.ones((n + 1) * n_x)
    jac_g = _matrix(
        (sum(of.rows), of.n_variables),
        jacobian_places(of, each.jacobian_pattern, end.jacobian_pattern),
        ca.vertcat(ca.vec(jacobian), end_jacobian, ones),
    )

    multipliers = ca.reshape(ca.vertcat(lam_g[:n_rows], lam_g[n_rows + n_x : n_x + n * n_rows]), n_rows, n)
    hessian = each.hessian(*inputs, lam_f, multipliers)
    end_hessian = end.hessian(last, shared, ca.DM.zeros(2), lam_f, lam_g[n_x + n * n_rows :])
    places = hessian_places(of, each.hessian_pattern, end.hessian_pattern)
    hess_l = _matrix((of.n_variables,) * 2, places, ca.vertcat(ca.vec(hessian), end_hessian))
    outputs = {
        "f": ca.sum2(cost) + end_cost,
        "g": g,
        "grad_f_x": grad_f,
        "jac_g_x": jac_g,
        "grad_gamma_x": lam_f * grad_f + ca.mtimes(jac_g.T, lam_g),
        "grad_gamma_p": ca.MX.zeros(p.shape),  # fatrop expects it and does not use it
        "hess_gamma_x_x": hess_l,
        "triu_hess_gamma_x_x": ca.triu(hess_l),
    }
    return Programme({"x": x, "p": p, "lam_f": lam_f, "lam_g": lam_g}, outputs)


@dataclass(frozen=True)
class _StageFunctions:
    """Functions of (stage variables, shared parameters, data); matrices as the columns of their nonzeros."""

    value: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    jacobian_pattern: ca.Sparsity
    hessian_pattern: ca.Sparsity

    @classmethod
    def of(cls, stage: Interval, times: int = 1) -> "_StageFunctions":
        """The functions of a stage, mapped over `times` stages."""
        w = ca.vertcat(stage.state, stage.inner)
        own = ca.vertcat(-stage.following, stage.equalities, stage.margins)
        symbol: Any = type(w).sym  # type: ignore[attr-defined]
        lam_f, lam_g = symbol("lam_f"), symbol("lam_g", own.numel())
        jacobian = ca.jacobian(own, w)
        hessian = ca.hessian(lam_f * stage.cost + ca.dot(lam_g, own), w)[0]
        inputs = [w, stage.parameters, stage.data]

        def function(name: str, arguments: list[Any], results: list[Any], repeated: list[int]) -> ca.Function:
            of_one = ca.Function(name, arguments, results, {"cse": True})
            return of_one if times == 1 else of_one.map(f"{name}_map", "serial", times, repeated, [])

        gradient = ca.densify(ca.gradient(stage.cost, w))
        return cls(
            function("value", inputs, [stage.cost, ca.densify(own)], [1]),
            function("jacobian", inputs, [gradient, _nonzeros(jacobian)], [1]),
            function("hessian", [*inputs, lam_f, lam_g], [_nonzeros(hessian)], [1, 3]),
            jacobian.sparsity(),
            hessian.sparsity(),
        )


def _nonzeros(matrix: Expression) -> Expression:
    column: Any = ca.vec(matrix)
    return column.nz[:]


def jacobian_places(of: Transcription, stage: ca.Sparsity, end: ca.Sparsity) -> np.ndarray:
    """Rows and columns of the Jacobian, (2, nonzeros), from the patterns of one stage and of the last.

    The order is that of the stages, the last, and the identities of following states and of the first state.
    """
    n, n_x, n_w, n_rows = of.n_intervals, of.n_x, of.n_w, of.n_rows
    columns = np.arange(n) * n_w
    starts = np.arange(n) * n_rows + n_x * (np.arange(n) > 0)
    identity = ca.Sparsity.diag(n_x)
    return np.hstack(
        [
            _placed(stage, starts, columns),
            _placed(end, [n * n_rows + n_x], [n * n_w]),
            _placed(identity, starts, columns + n_w),
            _placed(identity, [n_rows], [0]),
        ]
    )


def hessian_places(of: Transcription, stage: ca.Sparsity, end: ca.Sparsity) -> np.ndarray:
    """Rows and columns of the Hessian, (2, nonzeros): the stages, then the last."""
    offsets, last = np.arange(of.n_intervals) * of.n_w, [of.n_intervals * of.n_w]
    return np.hstack([_placed(stage, offsets, offsets), _placed(end, last, last)])


def _placed(
    pattern: ca.Sparsity, row_offsets: Sequence[int] | np.ndarray, column_offsets: Sequence[int] | np.ndarray
) -> np.ndarray:
    """Row and column of every nonzero of copies of a pattern at these offsets, (2, copies * nonzeros)."""
    rows, columns = (np.array(index, dtype=int) for index in pattern.get_triplet())
    return np.stack(
        [np.add.outer(np.asarray(row_offsets), rows).ravel(), np.add.outer(np.asarray(column_offsets), columns).ravel()]
    )


def _matrix(shape: tuple[int, int], places: np.ndarray, values: ca.MX) -> ca.MX:
    rows, columns = places
    order = np.lexsort((rows, columns))
    pattern = ca.Sparsity.triplet(*shape, rows[order].tolist(), columns[order].tolist())
    return ca.MX(pattern, values[order.tolist()])
