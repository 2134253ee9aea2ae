"""Models that are linear in their weights: the prepared columns are streamed, and no basis is evaluated again."""

import numpy as np
import torch

from repro.learning.kernels.kernel import Kernel
from repro.learning.problem import Problem, Task
from repro.models.model import Model

_SOURCE = """
#include <math.h>
#include <stdint.h>
#define COLUMNS {columns}
#define AHEAD 4 /* samples fetched in advance: their order is random */

static void linear_gradient(const double *data, const int64_t *order, int64_t count, double factor,
                            const double *parameters, double *total, int64_t rows) {{
  const int64_t size = rows * (COLUMNS + 1);
  double sum[COLUMNS] = {{0}}, loss = 0;
  for (int64_t s = 0; s < count; s++) {{
    if (order && s + AHEAD < count)
      for (int64_t k = 0; k < size; k += 8) __builtin_prefetch(data + size * order[s + AHEAD] + k);
    const double *row = data + size * (order ? order[s] : s);
    for (int64_t r = 0; r < rows; r++, row += COLUMNS + 1) {{
      double error = -row[COLUMNS];
      for (int k = 0; k < COLUMNS; k++) error += row[k] * parameters[k];
      loss += error * error;
      for (int k = 0; k < COLUMNS; k++) sum[k] += error * row[k];
    }}
  }}
  total[0] += factor * loss;
  for (int k = 0; k < COLUMNS; k++) total[1 + k] += 2 * factor * sum[k];
}}
"""


def linear_kernel(problem: Problem) -> Kernel | None:
    """The kernel of a problem whose rows are linear in the weights, or None."""
    model, objectives = problem.model, [task.objective for task in problem.tasks]
    if len(model.coefficient_names) != model.n_parameters or model.n_parameters == 0:
        return None
    if any(objective.equation == "forward" or objective.transform_weight for objective in objectives):
        return None
    data = [_pack(model, task) for task in problem.tasks]
    source = _SOURCE.format(columns=model.n_parameters)
    for number, packed in enumerate(data):
        rows = packed.shape[-1] // (model.n_parameters + 1)
        source += f"#define gradient_{number}(...) linear_gradient(__VA_ARGS__, {rows})\n"
    return Kernel(source, data)


def _pack(model: Model, task: Task) -> np.ndarray:
    """Samples (member, sample, row (n_parameters + 1)): the derivatives of each row, and its right-hand side."""
    members = len(task.measured["qd"])
    packed = []
    for member in range(members):
        alone = task.member(member)
        zero = torch.zeros(1, model.n_parameters, dtype=torch.float64)
        values, columns = model.rows(zero, alone.prepared, alone.rows, mass=False)
        rows = torch.cat([columns[0].transpose(0, 1), -values[0].unsqueeze(-1)], dim=-1)
        packed.append(task.samples**0.5 * rows.flatten(1).numpy())
    return np.stack(packed)
