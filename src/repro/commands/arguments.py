"""What several commands read from their command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from repro.errors import UserError
from repro.tracking import ids, record
from repro.tracking.paths import Paths
from repro.tracking.record import Record

if TYPE_CHECKING:
    pass


def stored_record(paths: Paths, text: str) -> Record:
    """The stage that an id, its start or its last digits name; UserError for a damaged, missing or ambiguous one."""
    folder = ids.resolve(paths, text)
    try:
        return record.read(folder)
    except record.Damage as damage:
        raise UserError(f"{folder} is damaged ({damage}); the command that made it makes it again") from damage
