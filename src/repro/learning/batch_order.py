"""The order in which an epoch goes over the samples."""

import ctypes
from functools import cache

import numpy as np

from repro.codegen.c_library import load_library
from repro.codegen.c_source import c_source
from repro.codegen.lanes import FAST
from repro.learning import kernels
from repro.learning.kernels.kernel import address
from repro.learning.native import can_compile


def shuffled(seed: int, samples: int, epoch: int) -> np.ndarray:
    """A fresh order (sample,) of int32 from (seed, epoch) alone, so that a resumed run sees the same batches."""
    generator = np.random.PCG64([seed, 11, epoch])
    if not can_compile():
        return np.random.Generator(generator).permutation(samples).astype(np.int32)
    state = generator.state["state"]
    halves = np.array([divmod(state[name], 1 << 64) for name in ("state", "inc")], dtype=np.uint64)
    order = np.empty(samples, dtype=np.int32)
    _library().shuffle(address(halves), address(order), ctypes.c_int64(samples))
    return order


@cache
def _library() -> ctypes.CDLL:
    return load_library(c_source(kernels.__file__, "shuffle"), FAST)
