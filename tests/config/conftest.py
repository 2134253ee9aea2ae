"""Configurations composed as by a command of its own, whose jobs never start."""

import pytest

from repro.config.compose import FEW


@pytest.fixture(autouse=True)
def _composed_as_a_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("repro.config.compose.FEW", FEW)
    # It would load torch beside the tests, for no job.
    monkeypatch.setattr("repro.commands.run.start_server", lambda preload: None)
