"""Loss and gradient as compiled C, and epochs of Adam around them: several times faster than torch."""

import ctypes
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from repro.codegen.c_library import load_library
from repro.codegen.c_source import c_source
from repro.codegen.lanes import FAST, can_compile
from repro.learning import kernels
from repro.learning.kernels.generated import generated_kernel
from repro.learning.kernels.kernel import ENDLESS, Evaluations, Kernel, address
from repro.learning.kernels.network_kernel import network_kernel
from repro.learning.kernels.positions import position_kernel
from repro.learning.training_problem import TrainingProblem

COMPILATION_S = 0.6  # of a loss and its gradient: 0.2 to 1.4 s


class NativeProblem:
    """A problem's datasets packed for a kernel, in double or single precision; one member at a time."""

    def __init__(self, problem: TrainingProblem, kernel: Kernel, real: type[np.floating] = np.float64) -> None:
        self.n_parameters, self.real = problem.model.n_parameters, real
        self.data = [data.astype(real, copy=False) for data in kernel.data]
        self.counts = np.array([data.shape[1] for data in self.data], dtype=np.int64)
        self.l1 = np.zeros(self.n_parameters) if problem.l1 is None else problem.l1.double().numpy()
        self.l1 = self.l1.astype(real)
        self.library = _training_library(kernel, self.n_parameters, real)

    def loss_and_gradient(self, member: int, parameters: np.ndarray) -> tuple[float, np.ndarray]:
        """Loss and gradient (n_parameters,) on all samples of one member, at weights of the problem's precision."""
        total = np.zeros(1 + self.n_parameters, self.real)
        self.library.loss_and_gradient(
            self._pointers(member), address(self.counts), address(parameters), address(total)
        )
        return float(total[0] + self.l1 @ np.abs(parameters)), total[1:] + self.l1 * np.sign(parameters)

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

        state: parameters, first and second moments (n_parameters,) each, updated in place; rates: one per step;
        constants: the decay of both moments, and epsilon.
        """
        places = np.ascontiguousarray(order, dtype=np.int32)
        loss: float = self.library.adam_epoch(
            self._pointers(member), address(self.counts), address(places), ctypes.c_int64(batch), address(rates),
            *map(ctypes.c_double, constants), address(self.l1), *map(address, state),
        )  # fmt: skip
        return loss

    def _pointers(self, member: int) -> ctypes.Array[ctypes.c_void_p]:
        return (ctypes.c_void_p * len(self.data))(*(data[member].ctypes.data for data in self.data))


def native(
    problem: TrainingProblem, real: type[np.floating] = np.float64, evaluations: Evaluations = ENDLESS
) -> NativeProblem | None:
    """The problem in compiled code, or None.

    None where there is no compiler, where so many evaluations take torch less time than the compiler, or where there is
    no kernel for model, rows and precision.
    """
    few = evaluations.seconds_saved(problem.model.n_parameters) < COMPILATION_S
    if few or any(task.share is not None for task in problem.tasks) or not can_compile():
        return None
    kernel = network_kernel(problem)
    if kernel is None and real == np.float64:
        kernel = position_kernel(problem) or generated_kernel(problem)
    return None if kernel is None else NativeProblem(problem, kernel, real)


def _training_library(kernel: Kernel, n_parameters: int, real: type[np.floating]) -> ctypes.CDLL:
    calls = []
    for number in range(len(kernel.data)):
        count, order = (f"counts[{number}]", "0") if number else ("batch", "order")
        calls.append(f"  gradient_{number}(data[{number}], {order}, {count}, 1.0 / {count}, parameters, total);")
    values = {"outputs": 1 + n_parameters, "n_parameters": n_parameters, "calls": "\n".join(calls)}
    text = c_source(kernels.__file__, "training", **values)
    precision = f"typedef {'float' if real == np.float32 else 'double'} real;\n"
    library = load_library(precision + kernel.source + text, FAST)
    library.adam_epoch.restype = ctypes.c_double
    library.loss_and_gradient.restype = None
    return library


def shuffled(seed: int, samples: int, epoch: int) -> np.ndarray:
    """A fresh order (sample,) of int32 from (seed, epoch) alone, so that a resumed run sees the same batches."""
    generator = np.random.PCG64([seed, 11, epoch])
    if not can_compile():
        return np.random.Generator(generator).permutation(samples).astype(np.int32)
    state = generator.state["state"]
    halves = np.array([divmod(state[name], 1 << 64) for name in ("state", "inc")], dtype=np.uint64)
    order = np.empty(samples, dtype=np.int32)
    _shuffling().shuffle(address(halves), address(order), ctypes.c_int64(samples))
    return order


@lru_cache(maxsize=1)
def _shuffling() -> ctypes.CDLL:
    return load_library(c_source(kernels.__file__, "shuffle"), FAST)
