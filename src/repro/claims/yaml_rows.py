"""YAML files that are a list of rows, each checked against a pydantic model; a mistake is one line: file, row, key."""

from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, StringConstraints, ValidationError, model_validator

from repro.errors import UserError
from repro.plugins.checked import lines
from repro.tracking.files import read_yaml

Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("should be a number (YAML reads 5.0e-4 as a number, 5e-4 as text)")
    return float(value)


Number = Annotated[float, BeforeValidator(_number)]


class YamlRow(BaseModel):
    """A mapping in a YAML file; a key that is not a field is an error."""

    model_config = ConfigDict(frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_keys(cls, content: Any) -> Any:
        if isinstance(content, dict) and (unknown := [str(key) for key in content if key not in cls.model_fields]):
            raise ValueError(f"has unknown key {', '.join(unknown)}; allowed are {', '.join(cls.model_fields)}")
        return content


class NamedRow(YamlRow):
    """One row of a file, known by its id."""

    id: Text

    @property
    def name(self) -> str:
        """The name that sets the row apart from all others of its file."""
        return self.id


RowT = TypeVar("RowT", bound=NamedRow)


def load_rows(path: Path, model: type[RowT], if_repeated: str) -> list[RowT]:
    """Read and check all rows of a file.

    UserError, one line per mistake: no list, a malformed row, two of one name (`if_repeated` says what to do then).
    """
    rows, mistakes, contents = [], [], read_yaml(path)
    if not isinstance(contents, list):
        raise UserError(f"{path} must be a list of rows")
    for number, content in enumerate(contents, start=1):
        try:
            rows.append(model.model_validate(content))
        except ValidationError as error:
            id = content.get("id", "?") if isinstance(content, dict) else "?"
            mistakes += [f"{path.name}, row {number} ({id}): {line}" for line in lines(error, content)]
    names = [row.name for row in rows]
    if repeated := sorted({name for name in names if names.count(name) > 1}):
        mistakes.append(f"{path.name}: {', '.join(repeated)} occurs twice; {if_repeated}")
    if mistakes:
        raise UserError("\n".join(mistakes))
    return rows
