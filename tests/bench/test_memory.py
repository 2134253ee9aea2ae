"""Memory of one call."""

import math

import numpy as np
import pytest

from repro.bench import pairing
from repro.bench.pairing import peak_mib

needs_linux = pytest.mark.skipif(math.isnan(peak_mib(lambda: None)), reason="this system reports no peak memory")


@needs_linux
@pytest.mark.parametrize("mib", [50, 200])
def test_the_peak_of_a_call_is_seen_though_it_frees_everything(mib):
    assert peak_mib(lambda: np.ones(mib * 2**17).sum()) == pytest.approx(mib, abs=10)


@needs_linux
def test_what_was_held_before_does_not_count():
    held = np.ones(100 * 2**17)
    assert peak_mib(lambda: held[0] + 1) < 10


def test_a_system_that_does_not_tell_gives_no_number(monkeypatch, tmp_path):
    monkeypatch.setattr(pairing, "_STATUS", tmp_path / "none")
    assert math.isnan(peak_mib(lambda: None))
