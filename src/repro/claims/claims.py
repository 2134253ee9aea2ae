"""The paper's claims as rows: loaded from claims.yaml and checked before any of them is judged."""

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from repro.claims.predicate import Predicate
from repro.claims.selector import CardSelector, Selector
from repro.claims.verdict_kind import VerdictKind
from repro.claims.yaml_rows import NamedRow, Number, Text, YamlRow, load_rows


class ClaimKind(StrEnum):
    """How a claim is answered."""

    NUMBER = "number"
    STATEMENT = "statement"
    DECLARED = "declared"


class Declaration(StrEnum):
    """Why a number cannot be compared, which a row declares with its reason."""

    NOT_COMPARABLE = VerdictKind.NOT_COMPARABLE
    UNDER_SPECIFIED = VerdictKind.UNDER_SPECIFIED


_MEASURED = {"metric", "unit", "printed", "selector"}
_FIELDS: Mapping[ClaimKind, set[str]] = {
    ClaimKind.NUMBER: {*_MEASURED, "tolerance"},
    ClaimKind.STATEMENT: {"predicate"},
    ClaimKind.DECLARED: {*_MEASURED, "declared", "reason"},
}


class Tolerance(YamlRow):
    """How far a number may lie from the printed one, and why that far; one of the three bounds."""

    factor: Annotated[Number, Field(gt=1)] | None = None
    relative: Annotated[Number, Field(gt=0)] | None = None
    absolute: Annotated[Number, Field(gt=0)] | None = None
    reason: Text

    @model_validator(mode="after")
    def _has_one_bound(self) -> Self:
        if sum(bound is not None for bound in (self.factor, self.relative, self.absolute)) != 1:
            raise ValueError("has one of factor, relative, absolute, and a reason")
        return self

    def around(self, printed: float) -> tuple[float, float]:
        """Return the range that counts as matched, both ends included."""
        least, greatest = self._ends(printed)
        # The ends belong to the range: rounding must not push them out.
        slack = 1e-12 * (abs(least) + abs(greatest))
        return least - slack, greatest + slack

    def _ends(self, printed: float) -> tuple[float, float]:
        if self.factor is not None:
            return printed / self.factor, printed * self.factor
        half = (self.absolute or 0.0) if self.relative is None else self.relative * abs(printed)
        return printed - half, printed + half

    def __str__(self) -> str:
        if self.factor is not None:
            return f"×÷{self.factor:g}"
        return f"± {self.absolute:g}" if self.relative is None else f"± relative {self.relative:g}"


class Claim(NamedRow):
    """One row: a number with its tolerance, a statement with its predicate, or one declared not to be answerable."""

    part: str = ""
    kind: ClaimKind
    section: Text
    quote: Text
    about: Text
    experiment: Text
    metric: str = ""
    unit: str = ""
    printed: Number | None = None
    selector: CardSelector = Field(default_factory=dict)
    tolerance: Tolerance | None = None
    predicate: Predicate | None = None
    declared: Declaration | None = None
    reason: str = ""

    @model_validator(mode="after")
    def _has_the_fields_of_its_kind(self) -> Self:
        fields = {name for name in set().union(*_FIELDS.values()) if getattr(self, name) not in (None, "", {})}
        if missing := sorted(_FIELDS[self.kind] - fields):
            raise ValueError(f"a {self.kind} claim needs {', '.join(missing)}")
        if foreign := sorted(fields - _FIELDS[self.kind]):
            raise ValueError(f"a {self.kind} claim has no {', '.join(foreign)}")
        return self

    @property
    def name(self) -> str:
        """The id with its part: C1a."""
        return f"{self.id}{self.part}"

    @property
    def quantity(self) -> str:
        """The metric that it is judged by, its own or its predicate's; empty for a statement on several or on loops."""
        return self.metric if self.predicate is None else getattr(self.predicate, "metric", "")

    @property
    def selectors(self) -> list[Selector]:
        """What selects the runs that answer it; a statement can have two."""
        return [self.selector] if self.predicate is None else self.predicate.selectors

    def by_metric(self, metric: str) -> Self:
        """The same claim judged by another metric."""
        if self.predicate is None:
            return self.model_copy(update={"metric": metric})
        return self.model_copy(update={"predicate": self.predicate.model_copy(update={"metric": metric})})


def load_claims(path: Path) -> list[Claim]:
    """Read and check claims.yaml. Raises UserError, one line per mistake."""
    return load_rows(path, Claim, if_repeated="give the rows different parts")
