"""A solver in a child process, which the system kills when one solution takes too much CPU time.

fatrop may stall inside one call despite its limit on iterations, and nothing in its own process can stop it then.
"""

import pickle
import signal
import subprocess
import sys
from typing import Any, BinaryIO

import numpy as np

from repro.control.nonlinear_solver import CompiledProgramme, Solution, Solver


class GuardedSolver:
    """Solves in a child process; a solution that takes more than `seconds` of CPU time is abandoned."""

    def __init__(self, programme: CompiledProgramme, seconds: float) -> None:
        self.programme, self.seconds = programme, seconds
        self.process: subprocess.Popen[bytes] | None = None

    def __call__(self, parameters: np.ndarray, guess: np.ndarray) -> Solution:
        """The solution, or one without variables and the status "killed"."""
        process = self._running()
        assert process.stdin is not None and process.stdout is not None
        try:
            _write(process.stdin, (parameters, guess))
            solution: Solution = _read(process.stdout)
            return solution
        except (EOFError, BrokenPipeError):
            self.close()
            nothing = np.full_like(guess, np.nan)
            return Solution(nothing, False, np.inf, 0, "killed", np.nan, self.seconds)

    def close(self) -> None:
        """End the child."""
        if self.process is not None:
            for pipe in (self.process.stdin, self.process.stdout):
                assert pipe is not None
                pipe.close()
            self.process.kill()
            self.process.wait()
            self.process = None

    def _running(self) -> subprocess.Popen[bytes]:
        if self.process is None:
            command = [sys.executable, "-m", __name__]
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            assert self.process.stdin is not None
            _write(self.process.stdin, (self.programme, self.seconds))
        return self.process


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Start the programme's solver and answer requests until their end."""
    programme, seconds = _read(requests)
    solver: Solver = programme.start()
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    while True:
        try:
            parameters, guess = _read(requests)
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_PROF, seconds)
        solution = solver(parameters, guess)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        _write(answers, solution)


def _write(pipe: Any, content: Any) -> None:
    pickle.dump(content, pipe, protocol=pickle.HIGHEST_PROTOCOL)
    pipe.flush()


def _read(pipe: Any) -> Any:
    return pickle.load(pipe)


if __name__ == "__main__":
    serve(sys.stdin.buffer, sys.stdout.buffer)
