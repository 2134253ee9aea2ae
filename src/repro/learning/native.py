"""Loss, gradient and Jacobian of a small model as compiled straight-line code over vectors of samples.

The code is generated from the model's energies by symbolic differentiation, so every model that can write its energies
as an expression gets it. Large networks stay with torch, where matrix products win.
"""

import ctypes
import re
from collections.abc import Sequence
from functools import lru_cache

import casadi
import numpy as np

from repro.learning.objective import Objective
from repro.learning.problem import Problem, Task
from repro.learning.symbolic import COLUMNS, residual, symbols
from repro.mechanics.c_library import CompilerError, load_library
from repro.mechanics.straight_line import statements
from repro.models.model import Model

LARGEST = 6000  # statements: above this a compiler takes longer than it saves, and torch is faster
LANES = 4
FLAGS = ("-O3", "-march=native", "-ffast-math")

_PRELUDE = """
#include <math.h>
#include <stdint.h>
#define LANES {lanes}
typedef double vec __attribute__((vector_size(8 * LANES)));
static inline vec splat(double x) {{ vec r; for (int l = 0; l < LANES; l++) r[l] = x; return r; }}
#define UNARY(name, expression) \\
  static inline vec v_##name(vec a) {{ vec r; for (int l = 0; l < LANES; l++) r[l] = expression; return r; }}
#define BINARY(name, expression) \\
  static inline vec v_##name(vec a, vec b) {{ vec r; for (int l = 0; l < LANES; l++) r[l] = expression; return r; }}
UNARY(exp, exp(a[l])) UNARY(log, log(a[l])) UNARY(log1p, log1p(a[l])) UNARY(sin, sin(a[l])) UNARY(cos, cos(a[l]))
UNARY(tan, tan(a[l])) UNARY(tanh, tanh(a[l])) UNARY(fabs, fabs(a[l])) UNARY(sqrt, sqrt(a[l]))
UNARY(sign, (a[l] > 0) - (a[l] < 0)) UNARY(negation, a[l] == 0)
BINARY(less, a[l] < b[l]) BINARY(less_equal, a[l] <= b[l]) BINARY(equal, a[l] == b[l])
BINARY(unequal, a[l] != b[l]) BINARY(if_else_zero, a[l] != 0 ? b[l] : 0)
BINARY(fmax, fmax(a[l], b[l])) BINARY(fmin, fmin(a[l], b[l])) BINARY(pow, pow(a[l], b[l]))
"""

_GRADIENT = """
static void gradient_{number}(const double *data, const int64_t *order, int64_t count, double factor,
                              const double *parameters, double *total) {{
  vec sum[{outputs}] = {{0}};
  for (int64_t s = 0; s < count; s += LANES) {{
    vec {arrays};
    for (int l = 0; l < LANES; l++) {{
      int64_t inside = s + l < count;
      const double *row = data + {columns} * (order ? order[inside ? s + l : s] : (inside ? s + l : s));
      {load}
      weight[0][l] *= inside;
    }}
    vec {work};
{statements}
  }}
  for (int p = 0; p < {outputs}; p++) {{
    double lanes = 0;
    for (int l = 0; l < LANES; l++) lanes += sum[p][l];
    total[p] += factor * lanes;
  }}
}}
"""

_TRAINING = """
static void gradients(const double **data, const int64_t *counts, const int64_t *order, int64_t batch,
                      const double *parameters, double *total) {{
  for (int p = 0; p < {outputs}; p++) total[p] = 0;
{calls}
}}

void loss_and_gradient(const double **data, const int64_t *counts, const double *parameters, double *total) {{
  gradients(data, counts, 0, counts[0], parameters, total);
}}

double adam_epoch(const double **data, const int64_t *counts, const int64_t *order, int64_t batch,
                  const double *rates, double beta_1, double beta_2, double epsilon, const double *l1,
                  double *parameters, double *first, double *second) {{
  double total[{outputs}], loss = 0;
  int64_t step = 0;
  for (int64_t start = 0; start < counts[0]; start += batch, step++) {{
    int64_t size = counts[0] - start < batch ? counts[0] - start : batch;
    gradients(data, counts, order + start, size, parameters, total);
    for (int p = 0; p < {n_parameters}; p++) total[0] += l1[p] * fabs(parameters[p]);
    loss += total[0] * size / counts[0];
    for (int p = 0; p < {n_parameters}; p++) {{
      double g = total[1 + p] + l1[p] * ((parameters[p] > 0) - (parameters[p] < 0));
      first[p] = beta_1 * first[p] + (1 - beta_1) * g;
      second[p] = beta_2 * second[p] + (1 - beta_2) * g * g;
      parameters[p] -= rates[step] * first[p] / (sqrt(second[p]) + epsilon);
    }}
  }}
  return loss;
}}
"""

_ROWS = """
void rows_{number}(const double *data, int64_t count, const double *parameters, double *result) {{
  for (int64_t s = 0; s < count; s += LANES) {{
    vec {arrays}, out[{outputs}];
    for (int l = 0; l < LANES; l++) {{
      const double *row = data + {columns} * (s + l < count ? s + l : s);
      {load}
    }}
    vec {work};
{statements}
    for (int l = 0; l < LANES && s + l < count; l++)
      for (int p = 0; p < {outputs}; p++) result[(s + l) * {outputs} + p] = out[p][l];
  }}
}}
"""


class NativeProblem:
    """A problem's datasets packed for generated code; one member at a time."""

    def __init__(self, problem: Problem) -> None:
        self.model, self.objectives = problem.model, tuple(task.objective for task in problem.tasks)
        self.data = [_pack(task) for task in problem.tasks]
        self.counts = np.array([data.shape[1] for data in self.data], dtype=np.int64)
        self.l1 = np.zeros(problem.model.n_parameters) if problem.l1 is None else problem.l1.double().numpy()

    def loss_and_gradient(self, member: int, parameters: np.ndarray) -> tuple[float, np.ndarray]:
        """Loss and gradient (n_parameters,) on all samples of one member."""
        total = np.zeros(1 + self.model.n_parameters)
        library = _training_library(self.model, self.objectives)
        library.loss_and_gradient(self._pointers(member), _address(self.counts), _address(parameters), _address(total))
        return total[0] + self.l1 @ np.abs(parameters), total[1:] + self.l1 * np.sign(parameters)

    def adam_epoch(
        self,
        member: int,
        order: np.ndarray,
        batch: int,
        rates: np.ndarray,
        constants: tuple[float, float, float],
        state: Sequence[np.ndarray],
    ) -> float:
        """One epoch of Adam over the first task in this order, the others whole at each step; the mean loss.

        state: parameters, first and second moments (n_parameters,) each, updated in place; rates: one a step;
        constants: the decay of both moments, and epsilon.
        """
        library = _training_library(self.model, self.objectives)
        return library.adam_epoch(
            self._pointers(member), _address(self.counts), _address(order), ctypes.c_int64(batch), _address(rates),
            *map(ctypes.c_double, constants), _address(self.l1), *map(_address, state),
        )  # fmt: skip

    def linearise(self, member: int, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """All residual rows (n_rows,) and their Jacobian (n_rows, n_parameters), weighted as in `Problem.linearise`."""
        values, jacobians = [], []
        for data, objective in zip(self.data, self.objectives, strict=True):
            library, n_rows = _rows_library(self.model, objective)
            result = np.empty((data.shape[1], n_rows, 1 + self.model.n_parameters))
            library.rows_0(_address(data[member]), ctypes.c_int64(len(result)), _address(parameters), _address(result))
            flat = result.reshape(-1, 1 + self.model.n_parameters) / np.sqrt(len(result))
            values.append(flat[:, 0])
            jacobians.append(flat[:, 1:])
        return np.concatenate(values), np.concatenate(jacobians)

    def _pointers(self, member: int) -> ctypes.Array:
        return (ctypes.c_void_p * len(self.data))(*(data[member].ctypes.data for data in self.data))


def native(problem: Problem) -> NativeProblem | None:
    """The problem in generated code, or None where there is no compiler or the model is too large for it."""
    if problem.model.n_parameters > 400 or not can_compile():
        return None
    sizes = [len(_gradient_statements(problem.model, task.objective)[0]) for task in problem.tasks]
    return NativeProblem(problem) if max(sizes) <= LARGEST else None


@lru_cache(maxsize=1)
def can_compile() -> bool:
    """Whether generated code can be compiled here."""
    # a compiler without the C library's headers is common, and a processor may refuse the flags
    try:
        load_library(_PRELUDE.format(lanes=LANES), FLAGS)
    except (CompilerError, OSError):
        return False
    return True


@lru_cache(maxsize=32)
def _gradient_statements(model: Model, objective: Objective) -> tuple[list[str], int]:
    s = symbols(model)
    loss = casadi.sumsqr(residual(model, objective, s))
    outputs = casadi.vertcat(loss, casadi.gradient(loss, s.parameters))
    return _vectorised(casadi.Function("gradient", s.inputs, [casadi.densify(outputs)], {"cse": True}), "sum")


@lru_cache(maxsize=32)
def _training_library(model: Model, objectives: tuple[Objective, ...]) -> ctypes.CDLL:
    outputs = 1 + model.n_parameters
    parts = [_PRELUDE.format(lanes=LANES)]
    calls = []
    for number, objective in enumerate(objectives):
        lines, n_work = _gradient_statements(model, objective)
        parts.append(_GRADIENT.format(number=number, outputs=outputs, **_body(model.n_q, lines, n_work)))
        count, order = (f"counts[{number}]", "0") if number else ("batch", "order")
        calls.append(f"  gradient_{number}(data[{number}], {order}, {count}, 1.0 / {count}, parameters, total);")
    text = _TRAINING.format(outputs=outputs, n_parameters=model.n_parameters, calls="\n".join(calls))
    library = load_library("".join([*parts, text]), FLAGS)
    library.adam_epoch.restype = ctypes.c_double
    library.loss_and_gradient.restype = None
    return library


@lru_cache(maxsize=32)
def _rows_library(model: Model, objective: Objective) -> tuple[ctypes.CDLL, int]:
    s = symbols(model)
    rows = residual(model, objective, s)
    outputs = casadi.horzcat(rows, casadi.jacobian(rows, s.parameters)).T
    lines, n_work = _vectorised(
        casadi.Function("rows", s.inputs, [casadi.densify(casadi.vec(outputs))], {"cse": True}), "out"
    )
    text = _ROWS.format(number=0, outputs=outputs.numel(), **_body(model.n_q, lines, n_work))
    return load_library(_PRELUDE.format(lanes=LANES) + text, FLAGS), rows.numel()


def _body(n_q: int, lines: Sequence[str], n_work: int) -> dict:
    widths = dict.fromkeys(COLUMNS[:4], n_q) | dict.fromkeys(COLUMNS[4:], 1)
    load, column = [], 0
    for name, width in widths.items():
        load += [f"{name}[{i}][l] = row[{column + i}];" for i in range(width)]
        column += width
    return {
        "arrays": ", ".join(f"{name}[{width}]" for name, width in widths.items()),
        "columns": column,
        "load": " ".join(load),
        "work": ", ".join(f"w{i}" for i in range(n_work)),
        "statements": "\n".join(f"    {line};" for line in lines),
    }


def _vectorised(function: casadi.Function, output: str) -> tuple[list[str], int]:
    lines, n_work = statements(function, (*COLUMNS, "parameters"), output)
    return [_vector_statement(line, output) for line in lines], n_work


def _vector_statement(line: str, output: str) -> str:
    # scalars instead of an array of work variables: these stay in registers
    target, value = re.sub(r"\bw\[(\d+)\]", r"w\1", line).split(" = ", 1)
    if value.startswith("parameters[") or re.fullmatch(r"-?[\d.e+-]+", value):
        value = f"splat({value})"
    value = re.sub(r"\b([a-z_0-9]+)\(", lambda m: m[0] if m[1] == "splat" else f"v_{m[1]}(", value)
    return f"{target} {'+=' if output == 'sum' and target.startswith('sum[') else '='} {value}"


def _pack(task: Task) -> np.ndarray:
    measured = task.measured
    members, samples, _ = measured["q"].shape
    energy = measured.get("energy")
    columns = [measured[name].double().numpy() for name in COLUMNS[:4]]
    columns.append(np.zeros((members, samples, 1)) if energy is None else energy.double().numpy()[..., None])
    weight = task.sample_weight
    columns.append(np.ones((members, samples, 1)) if weight is None else weight.double().numpy()[..., None])
    return np.concatenate(columns, axis=-1)


def _address(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
