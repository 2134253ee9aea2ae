"""The templates and how they write values: escaped unless they are markup of ours."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from repro.report import writing

HERE = Path(__file__).parent
ASSETS = HERE / "assets"
# A verdict is shown by its word and a sign; colour comes third.
SIGNS = {
    "consistent": "✓",
    "supported": "✓",
    "supported with changes": "▲",
    "true by construction": "=",
    "undecided": "≈",
    "too few": "≈",
    "under-specified": "?",
    "not comparable": "≠",
    "uninformative": "≠",
    "outside": "✕",
    "not supported": "✕",
    "not run": "·",
}


def rendered(template: str, **values: Any) -> str:
    """Fill one of the templates. A name that the template needs and does not get is an error."""
    return _environment().get_template(template).render(**values)


@cache
def _environment() -> Environment:
    """The templates' environment, with escaping on."""
    made = Environment(
        loader=FileSystemLoader(HERE / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        auto_reload=False,
    )
    made.globals["signs"] = SIGNS
    filters = (fact, writing.number, cells, prose, symbols)
    made.filters |= {write.__name__: write for write in filters}
    return made


def fact(value: Any) -> str:
    """Write any stored value: yes and no, three digits of a number, a dash where there is none."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return writing.number(value) if value is None or isinstance(value, float) else str(value)


def cells(values: Sequence[float]) -> Markup:
    """Write numbers as the cells of a row; most of a report's pages are such cells."""
    return Markup("".join(f"<td>{writing.number(value)}</td>" for value in values))


def symbols(text: str) -> Markup:
    """Write a text with its symbols as people do: D_H with an index, s^2 as a power; all else is escaped."""
    return Markup(_with_symbols(str(escape(text))))


def prose(text: str) -> Markup:
    """Turn Markdown (paragraphs, lists, emphasis, code) into markup; HTML inside is shown, not obeyed."""
    return Markup(_with_symbols(writing.COMMONMARK.render(text)))


def _with_symbols(text: str) -> str:
    return text.replace("D_H", "D<sub>H</sub>").replace("^2", "²")
