"""Marks of tests of what the project works without: a C compiler, the packages of an extra, a CUDA device.

A fresh machine has Python and make alone, and the suite must pass there. So these tests are skipped where what they
compare with is absent; what runs in its place is tested everywhere.
"""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import pytest
import torch

from repro.codegen.lanes import can_compile

needs_compiler = pytest.mark.skipif(not can_compile(), reason="compares generated code: needs a C compiler")
needs_device = pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")
without_device = pytest.mark.skipif(torch.cuda.is_available(), reason="is about machines without a CUDA device")


def needs_extra(extra: str, *packages: str) -> pytest.MarkDecorator:
    """Skip a test where a package of an extra of pyproject.toml is absent; without names the extra is the package."""
    absent = [name for name in packages or (extra,) if find_spec(name) is None]
    return pytest.mark.skipif(bool(absent), reason=f"{', '.join(absent)}: pip install -e '.[{extra}]'")


def compares_with(package: str) -> Callable[[Any], Any]:
    """Mark a test that compares with a package of the extra `peers`, whose own warnings are not the project's."""
    marks = (pytest.mark.extras, pytest.mark.filterwarnings("ignore"), needs_extra("peers", package))
    return lambda test: [test := mark(test) for mark in marks][-1]
