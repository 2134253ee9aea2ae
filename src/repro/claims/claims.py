"""The paper's claims as rows: loaded from claims.yaml and checked before any of them is judged."""

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from repro.claims.evidence import CardSelector, Selector
from repro.claims.loop_predicates import LoopPredicate
from repro.claims.ratio_predicates import RatioPredicate
from repro.claims.setting_predicates import SettingPredicate
from repro.claims.verdict_kind import VerdictKind
from repro.claims.yaml_rows import NamedRow, Number, Text, YamlRow, load_rows

# The vocabulary in which claims.yaml puts a statement of the paper to stored runs, found by `name`.
Predicate = Annotated[SettingPredicate | RatioPredicate | LoopPredicate, Field(discriminator="name")]


class ClaimKind(StrEnum):
    """How a claim is answered."""

    NUMBER = "number"
    STATEMENT = "statement"
    DECLARED = "declared"


class Declaration(StrEnum):
    """Why a number cannot be compared, which a row declares with its reason."""

    NOT_COMPARABLE = VerdictKind.NOT_COMPARABLE
    UNDER_SPECIFIED = VerdictKind.UNDER_SPECIFIED
    UNINFORMATIVE = VerdictKind.UNINFORMATIVE


_MEASURED = {"metric", "unit", "printed", "selector"}
_FIELDS: Mapping[ClaimKind, set[str]] = {
    ClaimKind.NUMBER: _MEASURED,
    ClaimKind.STATEMENT: {"predicate"},
    ClaimKind.DECLARED: {*_MEASURED, "declared", "reason"},
}


class Cure(YamlRow):
    """The smallest change that makes a claim hold, judged as the claim is; none found: `change` alone says so."""

    change: Text
    experiment: Text | None = None
    predicate: Predicate | None = None


class Change(YamlRow):
    """A change of this row after its first results, and the commit that made it."""

    commit: Annotated[str, Field(pattern=r"^[0-9a-f]{7,40}$")]
    change: Text
    reason: Text


class Claim(NamedRow):
    """One row of claims.yaml, which says at its head what each field holds; of its kind it has the fields alone."""

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
    predicate: Predicate | None = None
    declared: Declaration | None = None
    reason: str = ""
    with_changes: str = ""
    by_construction: str = ""
    cure: Cure | None = None
    history: list[Change] = Field(default_factory=list)

    @model_validator(mode="after")
    def _has_the_fields_of_its_kind(self) -> Self:
        fields = {name for name in set().union(*_FIELDS.values()) if getattr(self, name) not in (None, "", {})}
        if missing := sorted(_FIELDS[self.kind] - fields):
            raise ValueError(f"a {self.kind} claim needs {', '.join(missing)}")
        if foreign := sorted(fields - _FIELDS[self.kind]):
            raise ValueError(f"a {self.kind} claim has no {', '.join(foreign)}")
        if self.predicate is None and (self.with_changes or self.by_construction):
            raise ValueError("with_changes and by_construction belong to a statement")
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
