"""A checkpoint is whole or not there, and does not slow a fit down."""

import numpy as np
import pytest
import torch

from repro.pipeline.stages import fit as module
from repro.pipeline.stages.fit import FileCheckpoint

STATE = {"weights": torch.linspace(0, 1, 5).double(), "done": [(np.arange(3.0), [1.0, 0.5], "ok")], "epoch": 4}


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    return now


def test_what_was_saved_is_loaded(tmp_path, clock):
    checkpoint = FileCheckpoint(tmp_path)
    assert checkpoint.load() is None
    clock[0] += 11
    checkpoint.save(STATE)
    loaded = FileCheckpoint(tmp_path).load()
    assert torch.equal(loaded["weights"], STATE["weights"])
    np.testing.assert_array_equal(loaded["done"][0][0], STATE["done"][0][0])
    assert loaded["done"][0][1:] == ([1.0, 0.5], "ok") and loaded["epoch"] == 4


def test_it_writes_every_so_often(tmp_path, clock):
    checkpoint = FileCheckpoint(tmp_path)
    for passed, expected in ((1, None), (10, 1), (5, 1), (6, 3)):
        clock[0] += passed
        checkpoint.save({"number": (expected or 0)})
        loaded = checkpoint.load()
        assert (loaded and loaded["number"]) == expected


def test_a_write_that_fails_leaves_the_last_whole_state(tmp_path, clock, monkeypatch):
    checkpoint = FileCheckpoint(tmp_path)
    clock[0] += 11
    checkpoint.save(STATE)

    def half(state, file):
        file.write(b"half of it")
        raise OSError("no space left")

    monkeypatch.setattr(module.torch, "save", half)
    clock[0] += 11
    with pytest.raises(OSError, match="space"):
        checkpoint.save({"epoch": 5})
    assert checkpoint.load()["epoch"] == 4
