"""What the paper leaves open or gets wrong, what was chosen instead, and what else is tried in its place."""

from pathlib import Path
from typing import Annotated

from pydantic import Discriminator, Field, Tag

from repro.claims.yaml_rows import NamedRow, Text, YamlRow, load_rows


class Trial(YamlRow):
    """What takes the place of our choice, one alternative at a time, and the claims whose verdicts that may move."""

    claims: Annotated[list[Text], Field(min_length=1)]
    instead: Annotated[list[Text], Field(min_length=1)]
    both: str = ""
    only: str = ""


class Assumption(NamedRow):
    """One row of assumptions.yaml, which says at its head what each field holds."""

    where: Text
    quote: Text
    problem: Text
    choice: Text
    config: Text
    evidence: Text
    sensitivity: Annotated[
        Annotated[list[Trial], Field(min_length=1), Tag("trials")] | Annotated[Text, Tag("reason")],
        Discriminator(lambda content: "trials" if isinstance(content, list) else "reason"),
    ]

    @property
    def trials(self) -> list[Trial]:
        """What is tried in the place of our choice; empty where nothing can be."""
        return self.sensitivity if isinstance(self.sensitivity, list) else []

    @property
    def untried(self) -> str:
        """Why nothing is tried; empty where there are trials."""
        return self.sensitivity if isinstance(self.sensitivity, str) else ""


def load_assumptions(path: Path) -> list[Assumption]:
    """Read and check assumptions.yaml; none where there is no such file. Raises UserError, one line per mistake."""
    if not path.is_file():
        return []
    return load_rows(path, Assumption, if_repeated="give each row its own id")
