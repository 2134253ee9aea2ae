"""Problem (9) by multiple shooting as the C source of a library for fatrop.

The functions of one stage are vectorised over several stages. Sensitivities of the Runge-Kutta steps are propagated
forwards, multipliers backwards; results at a point are stored until the next point, so that gradient, Jacobian and
Hessian share them.
"""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import column_function
from repro.codegen.c_source import c_source
from repro.codegen.lanes import FUNCTIONS, TYPE, vector_function
from repro.control.interval import HorizonCost
from repro.control.programme import hessian_places, jacobian_places
from repro.control.rate import Rate
from repro.control.transcription import Transcription


def shooting_code(of: Transcription) -> str:
    """C source of the functions that fatrop looks up in a library, for a transcription by shooting."""
    rate = Rate(of.model)
    costs = HorizonCost(of.model, of.problem)
    state, u, shared, data = costs.symbols(ca.SX)
    nodes = {
        "start": (ca.vertcat(state, u), *costs.start()(state, u, shared, data)),
        "middle": (state, *costs.middle(state)),
        "end": (state, *costs.end(state, shared)),
    }
    kernels = [
        vector_function(rate.value, ("z", "weights")),
        vector_function(rate.jacobian, ("z", "weights")),
        vector_function(rate.hessian, ("z", "weights", "jacobian", "multipliers")),
    ]
    for name, (variables, cost, margins) in nodes.items():
        kernels += _node_kernels(name, [variables, shared, data], cost, margins)
    start, middle, end = (margins.numel() for _, _, margins in nodes.values())
    sizes = {
        "N": of.n_intervals,
        "N_Q": of.model.n_q,
        "N_U": of.n_u,
        "N_GOAL": costs.n_goal,
        "N_SHARED": of.n_parameters - of.n_x,
        "N_START": start,
        "N_MIDDLE": middle,
        "N_END": end,
        "SUBSTEPS": of.substeps,
    }
    dense, n = ca.Sparsity.dense, of.n_variables  # every block of a stage is dense
    jacobian = jacobian_places(of, dense(of.n_rows, of.n_w), dense(of.rows[-1], of.n_x))
    hessian = hessian_places(of, dense(of.n_w, of.n_w), dense(of.n_x, of.n_x))
    definitions = [f"#define {name} {value}" for name, value in sizes.items()]
    tables = [
        _table("double", "lengths", of.data[0]),
        _table("double", "counts", of.data[1]),
        _table("casadi_int", "jacobian_pattern", _compressed(sum(of.rows), n, jacobian)),
        _table("casadi_int", "hessian_pattern", _compressed(n, n, hessian)),
    ]
    assembled = [c_source(__file__, name) for name in ("shooting", "fatrop_interface")]
    types = [TYPE, "typedef long long int casadi_int;"]
    functions = [FUNCTIONS, c_source(__file__, "recent_angles")]
    return "\n".join([*definitions, *types, *functions, *tables, *kernels, *assembled])


def _node_kernels(name: str, inputs: list[ca.SX], cost: ca.SX, margins: ca.SX) -> list[str]:
    """The functions of a node of the horizon in z (n_z,), parameters shared by all nodes, and data of its interval.

    NAME_value     (z, shared, data) -> [cost | margins]
    NAME_jacobian  (z, shared, data) -> [cost | margins | d cost/dz | d margins/dz by rows]
    NAME_hessian   (z, shared, data, multipliers) -> d2(multipliers . [cost | margins])/dz2, all n_z^2 entries
    """
    z, both = inputs[0], ca.vertcat(cost, margins)
    multipliers = ca.SX.sym("lambda", both.numel())
    slopes = [ca.gradient(cost, z), ca.vec(ca.jacobian(margins, z).T)]
    hessian = ca.hessian(ca.dot(multipliers, both), z)[0]
    names = ("z", "shared", "data")
    return [
        vector_function(column_function(f"{name}_value", inputs, both), names),
        vector_function(column_function(f"{name}_jacobian", inputs, both, *slopes), names),
        vector_function(
            column_function(f"{name}_hessian", [*inputs, multipliers], ca.vec(hessian)), (*names, "multipliers")
        ),
    ]


def _compressed(n_rows: int, n_columns: int, places: np.ndarray) -> list[int]:
    pattern = ca.Sparsity.triplet(n_rows, n_columns, *places.tolist())
    return [*pattern.shape, *pattern.colind(), *pattern.row()]


def _table(kind: str, name: str, values: Sequence[float] | np.ndarray) -> str:
    return f"static const {kind} {name}[] = {{{', '.join(str(value) for value in values)}}};"
