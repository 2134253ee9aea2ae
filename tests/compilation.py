"""How tests compile generated C."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest


@contextmanager
def unoptimised() -> Iterator[None]:
    """Generated C is compiled as it stands, in a tenth of the time.

    For small problems whose numbers follow from the source alone. What an optimising compiler makes of each kind of
    source is compared in tests/learning/test_native.py, tests/mechanics/test_simulate.py and
    tests/control/test_shooting.py.
    """
    from repro.codegen import c_library
    from repro.control import solver

    optimised = c_library.library_file

    def plain(source: str, flags: Sequence[str]) -> Path:
        return optimised(source, ["-O0", *(flag for flag in flags if not flag.startswith("-O"))])

    with pytest.MonkeyPatch.context() as patch:
        for module in (c_library, solver):
            patch.setattr(module, "library_file", plain)
        yield
