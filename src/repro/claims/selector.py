"""Selectors of a claim: columns of a result table or settings, and the value or values that a run must have there."""

from collections.abc import Callable, Collection
from typing import Annotated

from pydantic import AfterValidator

from repro.results.table_schema import CARD, TABLES

Value = bool | int | float | str
Selector = dict[str, Value | list[Value]]


def _columns_of(columns: Collection[str], settings: bool = True) -> Callable[[Selector], Selector]:
    def checked(selector: Selector) -> Selector:
        unknown = sorted(name for name in selector if name not in columns and not (settings and "." in name))
        if unknown:
            dotted = ", and settings by their dotted keys, such as model.hidden" if settings else ""
            raise ValueError(f"has no column {', '.join(unknown)}; allowed are {', '.join(columns)}{dotted}")
        return selector

    return checked


CardSelector = Annotated[Selector, AfterValidator(_columns_of(CARD))]
LoopSelector = Annotated[Selector, AfterValidator(_columns_of(TABLES["control"]))]
BenchSelector = Annotated[Selector, AfterValidator(_columns_of(TABLES["bench"], settings=False))]
