"""Pages with a generated part, between two comments of its name; the scripts beside this file fill them."""

import re
from collections.abc import Sequence
from pathlib import Path


def write_or_check(page: Path, name: str, text: str, arguments: Sequence[str]) -> int:
    """Put the text between the marks of that name; with --check, write nothing and return 1 where it differs.

    Raises ValueError where the page has no such marks.
    """
    before = page.read_text(encoding="utf-8")
    marks = re.compile(rf"(?<=<!-- {name} -->\n).*?(?=<!-- end of {name} -->)", re.DOTALL)
    after, found = marks.subn(lambda _: text, before)
    if not found:
        raise ValueError(f"{page.name} has no marks `{name}`")
    if "--check" in arguments:
        return int(after != before)
    page.write_text(after, encoding="utf-8")
    return 0
