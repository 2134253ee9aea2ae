"""What every kind of compiled loss and gradient offers, and when it is worth its compilation."""

import ctypes
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from repro.models.network import Network

# What compiled code saves of torch's time, on one core: of each call, and of each sample and weight in it.
CALL_S = 3e-3
SAMPLE_AND_WEIGHT_S = 5e-8


@dataclass(frozen=True)
class Kernel:
    """C functions gradient_0, gradient_1, ... and the packed samples (member, sample, column) of the task of each.

    void gradient_k(const real *samples, const int32_t *order, int64_t count, real factor, const real *parameters,
    real *total) adds factor * [loss, gradient (n_parameters,)], summed over the samples `order` (all where it is null),
    to `total`. The type `real` is double; in a kernel for single precision it is float.
    """

    source: str
    data: list[np.ndarray]


def defines(constants: Mapping[str, object]) -> str:
    """Constants of the preprocessor."""
    return "".join(f"#define {name} {value}\n" for name, value in constants.items())


def network_constants(network: Network) -> dict[str, object]:
    """The sizes of a network, as the C files name them."""
    return {
        "INPUTS": network.n_in,
        "LAYERS": len(network.hidden),
        "WIDTHS": listed(network.hidden),
        "TANH": int(network.activation == "tanh"),
    }


def listed(numbers: Iterable[int]) -> str:
    """The entries of an initialiser."""
    return ", ".join(map(str, numbers))


def address(array: np.ndarray) -> ctypes.c_void_p:
    """Where a contiguous array lies."""
    return ctypes.c_void_p(array.ctypes.data)


def aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Zeros whose rows begin at cache lines, where a row fills whole ones."""
    room = np.zeros(math.prod(shape) + 8)
    start = -room.ctypes.data // 8 % 8
    return room[start : start + math.prod(shape)].reshape(shape)


@dataclass(frozen=True)
class Evaluations:
    """Of a loss and its derivatives by one process: about how many, on how many samples each."""

    count: float
    samples: float

    def seconds_saved(self, n_parameters: int) -> float:
        """What compiled code would save, the compiler's time not counted."""
        return self.count * (CALL_S + self.samples * n_parameters * SAMPLE_AND_WEIGHT_S)


ENDLESS = Evaluations(math.inf, math.inf)  # compile wherever it is possible
