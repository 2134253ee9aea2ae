"""Configurations whose jobs never start."""

import pytest


@pytest.fixture(autouse=True)
def _no_server(monkeypatch: pytest.MonkeyPatch) -> None:
    # It would load torch beside the tests, for no job.
    monkeypatch.setattr("repro.commands.run.start_server", lambda preload: None)
