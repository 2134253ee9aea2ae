"""Models whose rows hold no second derivative of their network: it in block products, its physics as generated code.

The network of a structured mass matrix sees positions alone, and the rows hold its outputs and their first derivatives
with respect to q. So the generated physics treats the outputs as y + Y (q' - q), differentiates, and puts q' = q in the
end. The outputs of a black box are the accelerations themselves.
"""

import copy
from dataclasses import dataclass
from functools import lru_cache

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function
from repro.codegen.c_source import c_source
from repro.codegen.lanes import FUNCTIONS, block, vectorised
from repro.learning.kernels.generated import MOST_PARAMETERS, entries, pack, widths
from repro.learning.kernels.kernel import Kernel, defines, listed, network_constants
from repro.learning.objective import Objective
from repro.learning.symbolic import COLUMNS, symbols
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.structured import Structured


def position_kernel(problem: TrainingProblem) -> Kernel | None:
    """The kernel of a problem with a structured mass matrix or a large black box, or None."""
    model = problem.model
    objectives = [task.objective for task in problem.tasks]
    if not isinstance(model, Structured | BlackBox) or any(o.momentum_weight or not o.symbolic for o in objectives):
        return None
    if isinstance(model, BlackBox) and model.n_parameters <= MOST_PARAMETERS:
        return None  # straight-line code is quicker
    if isinstance(model, Structured) and model.potential and model.potential.n_parameters > MOST_PARAMETERS:
        return None  # V belongs to the generated physics
    jets = [_jets(task) for task in problem.tasks]
    slopes = range(jets[0].shape[-1] - 1)
    moving = tuple(c for c in slopes if any(of_task[..., 1 + c].any() for of_task in jets))
    shared = [c_source(__file__, name) for name in ("matrix_products", "activations")]
    source = [_constants(model, moving), *shared, FUNCTIONS]
    source += [_physics(model, task.objective, moving, number) for number, task in enumerate(problem.tasks)]
    source.append(c_source(__file__, "jets"))
    for number in range(len(problem.tasks)):
        source.append(f"#define gradient_{number}(...) jets_gradient(__VA_ARGS__, physics_{number})\n")
    return Kernel("".join(source), [_pack(*each, moving) for each in zip(problem.tasks, jets, strict=True)])


@dataclass(frozen=True)
class _Outputs:
    """In the network's place: symbols of its outputs, which move with q as their derivatives say."""

    values: casadi.SX

    def expression(self, parameters: casadi.SX, z: casadi.SX) -> casadi.SX:
        return self.values


def _constants(model: Structured | BlackBox, moving: tuple[int, ...]) -> str:
    network = model.network
    own = _own(model)
    constants = network_constants(network) | {
        "OUTPUTS": network.n_out,
        "SKIP": int(network.skip),
        "START": model.network_slice.start,
        "QUANTITIES": 1 + len(moving),
        "VECTORS": 3,
        "MEASURED": 4 * model.n_q + 2,
        "OWN": len(own),
    }
    return f"{defines(constants)}static const int own[] = {{{listed(own)}}};\n"


def _own(model: Structured | BlackBox) -> list[int]:
    """The parameters outside the network."""
    inside = range(*model.network_slice.indices(model.n_parameters))
    return [index for index in range(model.n_parameters) if index not in inside]


@lru_cache(maxsize=32)
def _statements(model: Structured | BlackBox, objective: Objective, moving: tuple[int, ...]) -> tuple[list[str], int]:
    s, n_out = symbols(model), model.network.n_out
    outputs, here = casadi.SX.sym("outputs", 1 + len(moving), n_out), casadi.SX.sym("here", model.n_q)
    step = s.q - here
    values = outputs[0, :].T
    for number, coordinate in enumerate(moving, start=1):
        values += outputs[number, :].T * step[coordinate]
    stand_in = copy.copy(model)
    stand_in.network = _Outputs(values)  # type: ignore[assignment]
    rows = casadi.substitute(objective.expression(stand_in, s), here, s.q)
    loss = casadi.sumsqr(rows)
    own = casadi.gradient(loss, s.parameters)[_own(model)]
    found = casadi.vertcat(loss, casadi.gradient(loss, casadi.vec(outputs)), own)
    inputs = [*s.inputs[:-1], casadi.vec(outputs), s.parameters]
    return vectorised(column_function("physics", inputs, found), "out", (*COLUMNS, "outputs", "parameters"))


def _physics(model: Structured | BlackBox, objective: Objective, moving: tuple[int, ...], number: int) -> str:
    columns = enumerate(entries(model.n_q))
    return c_source(
        __file__,
        "physics",
        number=number,
        arrays=", ".join(f"{name}[{width}]" for name, width in widths(model.n_q).items()),
        load=" ".join(f"{name}[{i}] = columns[{column} * VECTORS + v];" for column, (name, i) in columns),
        **block(*_statements(model, objective, moving)),
    )


def _jets(task: TrainingTask) -> np.ndarray:
    """Of the network's inputs (member, sample, unit, quantity): value, and derivatives with respect to q."""
    name = "position" if isinstance(task.model, Structured) else "inputs"
    members = [task.member(member).prepared[name][0] for member in range(len(task.measured["q"]))]
    return np.stack([jets[:, [0, *range(2, jets.shape[1])]].double().transpose(1, 2).numpy() for jets in members])


def _pack(task: TrainingTask, jets: np.ndarray, moving: tuple[int, ...]) -> np.ndarray:
    """Samples (member, sample, column): the jets by unit and quantity, then COLUMNS."""
    chosen = jets[..., [0, *(1 + c for c in moving)]]
    return np.concatenate([chosen.reshape(*jets.shape[:2], -1), pack(task)], axis=-1)
