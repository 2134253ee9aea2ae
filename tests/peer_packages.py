"""Marks of tests that compare with other packages."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import pytest


def needs(package: str) -> Callable[[Any], Any]:
    """Mark a test that compares with a package of the extra `peers`, which the project works without."""
    marks = (
        pytest.mark.extras,
        pytest.mark.filterwarnings("ignore"),
        pytest.mark.skipif(find_spec(package) is None, reason="needs the extra `peers`"),
    )
    return lambda test: [test := mark(test) for mark in marks][-1]
