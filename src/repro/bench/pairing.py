"""Comparisons in pairs: ours and other timed in turn, so that whatever slows the machine down slows both."""

import ctypes
import math
import time
import timeit
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

THREADS = 1
LONG_S = 0.5  # a contender whose warm-up takes longer is not repeated within one timing
RATIOS = {"ratio_median": 0.5, "ratio_q25": 0.25, "ratio_q75": 0.75, "ratio_least": 0.0, "ratio_greatest": 1.0}
Clock = Callable[[], float]
_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")  # of the process that is timed


@dataclass(frozen=True)
class Rounds:
    """How long to go on: at least `least` pairs, then until `most` pairs or `limit_s` seconds."""

    least: int
    most: int
    limit_s: float
    shortest_s: float = 2e-3  # a contender that is quicker is repeated within one timing until it takes that long


@dataclass(frozen=True)
class Pairs:
    """Seconds of both contenders, pair by pair (pair,), infinite where a goal was not reached; MiB of memory."""

    ours: np.ndarray
    other: np.ndarray
    ours_mib: float = math.nan
    other_mib: float = math.nan
    found: str = ""  # a remark of the measurement, for the protocol

    def __len__(self) -> int:
        return len(self.ours)

    @property
    def ratios(self) -> np.ndarray:
        """other / ours of each pair that at least one contender finished."""
        finished = np.isfinite(self.ours) | np.isfinite(self.other)
        return np.asarray(self.other[finished] / self.ours[finished])

    def summary(self) -> dict[str, float]:
        """Ratio: median, quartiles, ends; medians of both times in ms (each an observed value); memory in MiB."""
        return {
            **dict(zip(RATIOS, _quantiles(self.ratios, [*RATIOS.values()]), strict=True)),
            "ours_ms": 1e3 * _quantiles(self.ours, [0.5])[0],
            "other_ms": 1e3 * _quantiles(self.other, [0.5])[0],
            "ours_mib": self.ours_mib,
            "other_mib": self.other_mib,
        }


@dataclass(frozen=True)
class PairedComparison:
    """Seconds of two contenders in pairs."""

    name: str
    ours: str
    other: str
    size: str
    members: int  # networks trained side by side in one timing, whose time is that of all of them together
    protocol: str  # how it is measured; {pairs} stands for their number, {found} for the remark of the measurement
    measure: Callable[[], Pairs]
    metric: str = ""  # the error that is to fall to `goal`, by a training from each of several starts; "" for one step
    goal: float = math.nan

    @property
    def label(self) -> str:
        """A label for the progress, different for each comparison."""
        until = "" if math.isnan(self.goal) else f", {self.metric} {self.goal:g}"
        return f"{self.name} {self.size}, {self.members}: {self.ours} / {self.other}{until}"

    def row(self, pairs: Pairs) -> dict[str, object]:
        """The row of the results, its columns in the order of the stored table."""
        return {
            **{name: getattr(self, name) for name in ("name", "ours", "other", "size", "members", "metric", "goal")},
            "starts": len(pairs) if self.metric else 1,
            "ours_reached": int(np.isfinite(pairs.ours).sum()) if self.metric else 1,
            "other_reached": int(np.isfinite(pairs.other).sum()) if self.metric else 1,
            **pairs.summary(),
            "threads": THREADS,
            "protocol": self.protocol.format(pairs=len(pairs), found=pairs.found),
        }


def interleaved(
    ours: Callable[[], object], other: Callable[[], object], rounds: Rounds, clock: Clock = time.process_time
) -> Pairs:
    """Time two contenders in turn, after a warm-up of both and with the garbage collector off."""
    timers = [timeit.Timer(call, timer=clock) for call in (ours, other)]
    contenders = [(timer, _repetitions(timer, rounds)) for timer in timers]
    pairs: list[list[float]] = []
    end = clock() + rounds.limit_s
    while len(pairs) < rounds.least or (len(pairs) < rounds.most and clock() < end):
        pairs.append([timer.timeit(repetitions) / repetitions for timer, repetitions in contenders])
    return Pairs(*np.array(pairs).T)


def with_memory(ours: Callable[[], object], other: Callable[[], object], rounds: Rounds) -> Pairs:
    """Time two contenders in turn, then measure the memory of one call of each."""
    return replace(interleaved(ours, other, rounds), ours_mib=peak_mib(ours), other_mib=peak_mib(other))


def _repetitions(timer: timeit.Timer, rounds: Rounds) -> int:
    if timer.timeit(1) > LONG_S:
        return 1
    return max(1, math.ceil(rounds.shortest_s / max(timer.timeit(1), 1e-9)))


def _quantiles(values: np.ndarray, shares: list[float]) -> list[float]:
    # without interpolation, which is not defined between a finite and an infinite value
    if not len(values):
        return [math.nan] * len(shares)
    return [float(value) for value in np.quantile(values, shares, method="inverted_cdf")]


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit torch, BLAS and OpenMP to one thread each, then restore their numbers of threads."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with threadpool_limits(limits=1):
            yield
    finally:
        torch.set_num_threads(before)


def peak_mib(call: Callable[[], object]) -> float:
    """MiB of resident memory that one call added at its peak; nan where the system does not report it."""
    try:
        # returns freed memory to the system, so that the call cannot reuse it unnoticed
        ctypes.CDLL("libc.so.6").malloc_trim(0)
        _RESET.write_text("5")  # resets the peak
        before = _read("VmRSS")
        call()
        return max(_read("VmHWM") - before, 0.0)
    except (OSError, AttributeError, StopIteration):
        return math.nan


def _read(key: str) -> float:
    lines = (line for line in _STATUS.read_text().splitlines() if line.startswith(key))
    return int(next(lines).split()[1]) / 1024
