"""The ledger of what the paper leaves open or gets wrong, and what was chosen instead."""

from dataclasses import dataclass, fields
from pathlib import Path

from repro.errors import UserError


@dataclass(frozen=True)
class Assumption:
    """One row: where the paper says what, why that cannot be replayed, our choice, its config key and its evidence."""

    id: str
    where: str
    quote: str
    problem: str
    choice: str
    config: str
    evidence: str


def load_assumptions(path: Path) -> list[Assumption]:
    """Read and check assumptions.yaml. Raises UserError naming the row and the field."""
    import yaml

    try:
        rows = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        message = f"{path} cannot be read: {error}"
        raise UserError(message) from error
    if not isinstance(rows, list):
        message = f"{path} must be a list of assumptions"
        raise UserError(message)
    names = [field.name for field in fields(Assumption)]
    for number, row in enumerate(rows, start=1):
        given = row if isinstance(row, dict) else {}
        faults = [f"{name} is missing" for name in names if not str(given.get(name) or "").strip()]
        faults += [f"{name} is no field" for name in given if name not in names]
        if faults:
            message = f"{path.name}, row {number} ({given.get('id', '?')}): {', '.join(faults)}"
            raise UserError(message)
    ids = [row["id"] for row in rows]
    if len(set(ids)) < len(ids):
        message = f"{path.name}: {', '.join(sorted({i for i in ids if ids.count(i) > 1}))} stands there twice"
        raise UserError(message)
    return [Assumption(**{name: str(row[name]).strip() for name in names}) for row in rows]
