"""The ledger of what the paper leaves open or gets wrong, what was chosen instead, and what else is tried."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.claims.named_rows import check_apart, read_rows
from repro.errors import UserError

TEXTS = ("id", "where", "quote", "problem", "choice", "config", "evidence")
FIELDS = (*TEXTS, "sensitivity")


@dataclass(frozen=True)
class Trial:
    """What is put in the place of our choice, one at a time, and the claims whose verdicts that may move.

    claims   their names, C4a
    instead  overrides, several to one alternative apart by blanks; metric=NAME judges the same runs by another metric
    both     overrides of either side, such as fewer closed loops
    only     an override that picks one of several jobs that answer the claim
    """

    claims: tuple[str, ...]
    instead: tuple[str, ...]
    both: str = ""
    only: str = ""


@dataclass(frozen=True)
class Assumption:
    """One row: where the paper says what, why that cannot be replayed, our choice, its settings and its evidence.

    `trials` are what its sensitivity is measured by; where there are none, `untried` says why.
    """

    id: str
    where: str
    quote: str
    problem: str
    choice: str
    config: str
    evidence: str
    trials: tuple[Trial, ...]
    untried: str

    @property
    def settings(self) -> list[str]:
        """The settings that hold the choice, apart: group=option | option, group.key; none for an erratum."""
        return [] if self.config.startswith("none") else [part.strip() for part in self.config.split(",")]


def load_assumptions(path: Path) -> list[Assumption]:
    """Read and check assumptions.yaml. Raises UserError naming the row and the field."""
    rows = read_rows(path, "assumptions")
    for number, row in enumerate(rows, start=1):
        given = row if isinstance(row, dict) else {}
        faults = [f"{name} is missing" for name in FIELDS if not str(given.get(name) or "").strip()]
        faults += [f"{name} is no field" for name in given if name not in FIELDS]
        if faults:
            message = f"{path.name}, row {number} ({given.get('id', '?')}): {', '.join(faults)}"
            raise UserError(message)
    check_apart(path, [row["id"] for row in rows], "give each an id of its own")
    return [_assumption(row, f"{path.name}, {row['id']}") for row in rows]


def _assumption(row: Mapping[str, Any], place: str) -> Assumption:
    texts = {name: str(row[name]).strip() for name in TEXTS}
    tried = row["sensitivity"]
    if isinstance(tried, str):
        return Assumption(**texts, trials=(), untried=tried.strip())
    if not isinstance(tried, list):
        message = f"{place}: sensitivity is a list of trials, or the reason why there is none"
        raise UserError(message)
    return Assumption(**texts, trials=tuple(_trial(each, place) for each in tried), untried="")


def _trial(content: Any, place: str) -> Trial:
    given = content if isinstance(content, dict) else {}
    lists = [given.get(name) for name in ("claims", "instead")]
    sound = all(isinstance(each, list) and each and all(isinstance(text, str) for text in each) for each in lists)
    others = {key: value for key, value in given.items() if key not in ("claims", "instead")}
    if not sound or not all(key in ("both", "only") and isinstance(value, str) for key, value in others.items()):
        message = f"{place}: a trial is {{claims: [C4a, ...], instead: [overrides, ...]}}, and perhaps both, only"
        raise UserError(message)
    return Trial(tuple(given["claims"]), tuple(given["instead"]), **others)
