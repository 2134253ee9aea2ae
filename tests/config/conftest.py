"""Configurations composed as by a command of its own."""

import pytest

from repro.config.compose import FEW


@pytest.fixture(autouse=True)
def _composed_as_a_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("repro.config.compose.FEW", FEW)
