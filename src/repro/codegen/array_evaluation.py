"""CasADi functions evaluated over arrays of points."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from repro.codegen.point_function import pays, point_function

BLOCK = 1024  # points evaluated together: enough to hide the call, few enough that repeated weights stay small


def column_function(name: str, inputs: Sequence[ca.SX], *parts: ca.SX) -> ca.Function:
    """A function of these symbols whose result is one dense column, the parts below each other."""
    return ca.Function(name, inputs, [ca.densify(ca.vertcat(*parts))], {"cse": True})


def evaluate(function: ca.Function, *arrays: np.ndarray, repeated: bool = False) -> np.ndarray:
    """Evaluate a function of column vectors over arrays of points.

    arrays: (..., n_i) with leading axes that broadcast; an array (n_i,) is used at every point, and inputs of size 0 at
    the end may be left out. At many points the function is compiled, where there is a compiler; `repeated`: at few
    points too. Returns (..., r) for a column of r, (..., r, c) for a wider matrix. ValueError where sizes do not fit.
    """
    given = [np.asarray(array, dtype=float) for array in arrays]
    given += [np.zeros(0)] * (function.n_in() - len(given))
    sizes = [function.numel_in(i) for i in range(function.n_in())]
    if [array.shape[-1] for array in given] != sizes:
        raise ValueError(f"{function.name()} takes vectors of {sizes}, got {[array.shape for array in given]}")
    leading = np.broadcast_shapes(*(array.shape[:-1] for array in given))
    points = math.prod(leading)
    rows, columns = function.size_out(0)
    flat = [a if a.ndim == 1 else np.broadcast_to(a, (*leading, a.shape[-1])).reshape(-1, a.shape[-1]) for a in given]
    result = np.empty((points, columns, rows))
    worth = repeated or pays(function, points)
    compiled = point_function(function, tuple(array.ndim == 1 for array in flat)) if worth else None
    if compiled is not None:
        compiled([np.ascontiguousarray(array) for array in flat], result)
    else:
        for start in range(0, points, BLOCK):
            stop = min(start + BLOCK, points)
            _map(function, [_rows(array, start, stop) for array in flat], result[start:stop])
    return result.reshape(*leading, rows) if columns == 1 else result.swapaxes(1, 2).reshape(*leading, rows, columns)


def _rows(array: np.ndarray, start: int, stop: int) -> np.ndarray:
    chosen = np.broadcast_to(array, (stop - start, array.shape[-1])) if array.ndim == 1 else array[start:stop]
    return np.ascontiguousarray(chosen).reshape(-1)


@lru_cache(maxsize=64)
def _mapped(function: ca.Function, points: int) -> ca.Function:
    return function.map(points)


def _map(function: ca.Function, inputs: list[np.ndarray], result: np.ndarray) -> None:
    # C order (point, component) is the column order that CasADi reads, so nothing is copied twice
    buffer: Any
    buffer, run = _mapped(function, len(result)).buffer()
    for i, values in enumerate(inputs):
        if values.size:
            buffer.set_arg(i, values.data)
    buffer.set_res(0, result.reshape(-1).data)
    run()
