"""Base of the options that are chosen in settings: frozen dataclasses with typed and bounded fields."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Annotated, Any, ClassVar

from annotated_types import Ge, Gt, Lt

Count = Annotated[int, Gt(0)]
Natural = Annotated[int, Ge(0)]
Positive = Annotated[float, Gt(0)]
NotNegative = Annotated[float, Ge(0)]
Share = Annotated[float, Gt(0), Lt(1)]


@dataclass(frozen=True)
class Options:
    """A group of options. Bounds and types are checked where settings are read, by `repro.config`."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "allow_inf_nan": False}

    def plain(self) -> dict[str, Any]:
        """All options as plain data, inner groups too: what a digest is taken of."""
        return {field.name: plain(getattr(self, field.name)) for field in fields(self)}


@dataclass(frozen=True)
class PluginOptions(Options):
    """The options of a choice that is a module of its own."""

    @property
    def kind(self) -> str:
        """Name of the choice: that of the module which declares these options."""
        return type(self).__module__.rpartition(".")[2]

    def plain(self) -> dict[str, Any]:
        """The kind and all options as plain data."""
        return {"kind": self.kind, **super().plain()}


def plain(value: Any) -> Any:
    """Options as dictionaries, sequences as lists, words of an enumeration as text; anything else unchanged."""
    if isinstance(value, Options):
        return value.plain()
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, StrEnum) else value
