"""Markdown of the report's texts as plain values that the typesetter walks: paragraphs, lists, emphasis, code."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from repro.report.writing import commonmark

if TYPE_CHECKING:
    from markdown_it.token import Token

STYLES = {"strong_open": "strong", "em_open": "emphasis", "strong_close": "plain", "em_close": "plain"}


def blocks(text: str) -> list[dict[str, Any]]:
    """Return {kind: paragraph, spans} and {kind: list, items: [spans]}, a span being {text, style}."""
    shown: list[dict[str, Any]] = []
    in_list = False
    for token in commonmark().parse(text):
        if token.type == "bullet_list_open":
            in_list = True
            shown.append({"kind": "list", "items": []})
        elif token.type == "bullet_list_close":
            in_list = False
        elif token.type == "fence":
            shown.append({"kind": "code", "text": token.content.rstrip()})
        elif token.type == "inline":
            spans = _spans(token.children or [])
            if in_list:
                shown[-1]["items"].append(spans)
            else:
                shown.append({"kind": "paragraph", "spans": spans})
    return shown


def _spans(tokens: Sequence["Token"]) -> list[dict[str, str]]:
    spans, style = [], "plain"
    for token in tokens:
        if token.type in STYLES:
            style = STYLES[token.type]
        elif token.type == "code_inline":
            spans.append({"text": token.content, "style": "code"})
        elif token.type in ("softbreak", "hardbreak"):
            spans.append({"text": " ", "style": style})
        elif token.content:
            spans.append({"text": token.content, "style": style})
    return spans
