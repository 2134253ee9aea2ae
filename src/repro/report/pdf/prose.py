"""Markdown of the report's texts as plain values that the typesetter walks: paragraphs, lists, emphasis, code.

[@key @key] cites entries of references.yaml; it is allowed in the texts that are shown in the PDF alone.
"""

import re
from collections.abc import Sequence
from typing import Any

from markdown_it.token import Token

from repro.report.writing import COMMONMARK

CITATION = re.compile(r"\[((?:@\w+ ?)+)\]")
STYLES = {"strong_open": "strong", "em_open": "emphasis", "strong_close": "plain", "em_close": "plain"}


def blocks(text: str) -> list[dict[str, Any]]:
    """Return {kind: paragraph, spans} and {kind: list, items: [spans]}, a span being {text, style}."""
    shown: list[dict[str, Any]] = []
    in_list = False
    for token in COMMONMARK.parse(text):
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


def _spans(tokens: Sequence[Token]) -> list[dict[str, str]]:
    spans, style = [], "plain"
    for token in tokens:
        if token.type in STYLES:
            style = STYLES[token.type]
        elif token.type == "code_inline":
            spans.append({"text": token.content, "style": "code"})
        elif token.type in ("softbreak", "hardbreak"):
            spans.append({"text": " ", "style": style})
        elif token.content:
            spans += _cited(token.content, style)
    return spans


def _cited(text: str, style: str) -> list[dict[str, str]]:
    # re.split alternates what lies between the citations with the citations.
    parts = enumerate(CITATION.split(text))
    return [
        {"text": part.replace("@", "").strip(), "style": "citation"} if place % 2 else {"text": part, "style": style}
        for place, part in parts
        if part
    ]
