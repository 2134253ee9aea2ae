"""The paper's claims as rows: loaded from claims.yaml and checked before any of them is judged."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from repro.claims.named_rows import check_apart, read_rows
from repro.claims.predicate_registry import check_predicate
from repro.errors import UserError
from repro.results.schema import CARD

Kind = Literal["number", "statement", "declared"]
DECLARED = ("not comparable", "under-specified")
BOUNDS = ("factor", "relative", "absolute")

REQUIRED: Mapping[str, tuple[str, ...]] = {
    "number": ("id", "section", "quote", "about", "experiment", "metric", "unit", "printed", "selector", "tolerance"),
    "statement": ("id", "section", "quote", "about", "experiment", "predicate"),
    "declared": (
        *("id", "section", "quote", "about", "experiment", "metric", "unit", "printed", "selector"),
        *("declared", "reason"),
    ),
}


@dataclass(frozen=True)
class Tolerance:
    """How far a number may lie from the printed one, and why that far; one of the three bounds."""

    kind: Literal["factor", "relative", "absolute"]
    size: float
    reason: str

    def around(self, printed: float) -> tuple[float, float]:
        """Return the range that counts as matched, both ends included."""
        least, greatest = self._ends(printed)
        # The ends belong to the range: rounding must not push them out.
        slack = 1e-12 * (abs(least) + abs(greatest))
        return least - slack, greatest + slack

    def _ends(self, printed: float) -> tuple[float, float]:
        if self.kind == "factor":
            return printed / self.size, printed * self.size
        half = self.size * abs(printed) if self.kind == "relative" else self.size
        return printed - half, printed + half

    def __str__(self) -> str:
        return {"factor": "×÷", "relative": "± relative ", "absolute": "± "}[self.kind] + f"{self.size:g}"


@dataclass(frozen=True)
class Claim:
    """One row: a number with its tolerance, a statement with its predicate, or one declared not to be answerable."""

    id: str
    part: str
    kind: Kind
    section: str
    quote: str
    about: str
    experiment: str
    metric: str = ""
    unit: str = ""
    printed: float | None = None
    selector: Mapping[str, Any] = field(default_factory=dict)
    tolerance: Tolerance | None = None
    predicate: Mapping[str, Any] = field(default_factory=dict)
    declared: str = ""
    reason: str = ""

    @property
    def name(self) -> str:
        """The id with its part: C1a."""
        return f"{self.id}{self.part}"


def load_claims(path: Path) -> list[Claim]:
    """Read and check claims.yaml. Raises UserError naming the claim, the field and what is allowed."""
    rows = enumerate(read_rows(path, "claims"), start=1)
    claims = [_claim(row, place=f"{path.name}, row {number}") for number, row in rows]
    check_apart(path, [claim.name for claim in claims], "tell the rows apart by `part`")
    return claims


def _claim(row: Any, place: str) -> Claim:
    if not isinstance(row, dict):
        message = f"{place}: a claim is a mapping, not {type(row).__name__}"
        raise UserError(message)
    name = f"{row.get('id', '?')}{row.get('part', '')}"
    kind = str(row.get("kind"))
    if kind not in REQUIRED:
        message = f"{place} ({name}): kind is {kind!r}; allowed: {', '.join(REQUIRED)}"
        raise UserError(message)
    missing = [key for key in REQUIRED[kind] if row.get(key) in (None, "")]
    if missing:
        message = f"{place} ({name}): a {kind} claim needs {', '.join(missing)}"
        raise UserError(message)
    unknown = sorted(set(row) - {*REQUIRED[kind], "kind", "part"})
    if unknown:
        message = f"{place} ({name}): {', '.join(unknown)} is not a field of a {kind} claim (verdicts are computed)"
        raise UserError(message)
    fields = {**row, "part": str(row.get("part", ""))}
    if kind == "number":
        fields["tolerance"] = _tolerance(row["tolerance"], f"{place} ({name})")
    if kind == "statement":
        check_predicate(row["predicate"], f"{place} ({name})")
    if kind == "declared" and row["declared"] not in DECLARED:
        message = f"{place} ({name}): declared is {row['declared']!r}; allowed: {', '.join(DECLARED)}"
        raise UserError(message)
    if kind != "statement":
        fields["printed"] = _number(row["printed"], f"{place} ({name}): printed")
        check_selector(row["selector"], f"{place} ({name})")
    return Claim(**fields)


def check_selector(where: Any, place: str) -> None:
    """Refuse a selector that names something else than card columns. Raises UserError."""
    if not isinstance(where, dict):
        message = f"{place}: a selector is a mapping of card columns to values"
        raise UserError(message)
    unknown = sorted(str(column) for column in where if column not in CARD)
    if unknown:
        message = f"{place}: {', '.join(unknown)} is not a card column; allowed: {', '.join(CARD)}"
        raise UserError(message)


def _tolerance(content: Any, place: str) -> Tolerance:
    allowed = f"{place}: a tolerance has one of {', '.join(BOUNDS)} and a reason"
    if not isinstance(content, dict) or not content.get("reason"):
        raise UserError(allowed)
    bounds = [key for key in content if key != "reason"]
    if len(bounds) != 1 or bounds[0] not in BOUNDS:
        raise UserError(allowed)
    size = _number(content[bounds[0]], f"{place}: {bounds[0]}")
    if size <= (1.0 if bounds[0] == "factor" else 0.0):
        message = f"{place}: {bounds[0]} {size:g} leaves no room; a factor is above 1, the others above 0"
        raise UserError(message)
    return Tolerance(bounds[0], size, str(content["reason"]))


def _number(value: Any, place: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        message = f"{place} is {value!r}, not a number (YAML reads 5.30e-4 as a number, 5e-4 as text: write 5.0e-4)"
        raise UserError(message)
    return float(value)
