"""How numbers and words are written: three significant figures, and the same text as Markdown, LaTeX and HTML."""

import math
import re

from repro.results.statistics import Estimate

ABSENT = "–"

_LATEX_SPECIAL = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "–": "--",
    "∞": r"$\infty$",
    "→": r"$\to$",
    "×": r"$\times$",
    "⚠": r"$\triangle$",
    "⊗": r"$\otimes$",
    "÷": r"$\div$",
    "±": r"$\pm$",
    "τ": r"$\tau$",
    "²": r"\textsuperscript{2}",
    "ₓ": r"\textsubscript{x}",
}


def number(value: float | None) -> str:
    """Write a number with three significant figures: 0.26, 39.4, 1420, 5.3e-4."""
    if value is None or math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.0f}" if abs(value) >= 999.5 else f"{value:.3g}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"


def interval(found: Estimate) -> str:
    """Write a median with its interval: 0.21 [0.15, 0.31]; the interval is left out where there is none."""
    if math.isnan(found.low) or math.isnan(found.high):
        return number(found.median)
    return f"{number(found.median)} [{number(found.low)}, {number(found.high)}]"


def latex(text: str) -> str:
    """Escape text for LaTeX and set powers of ten as such."""
    escaped = "".join(_LATEX_SPECIAL.get(character, character) for character in text)
    return re.sub(r"(?<![\w.-])(-?\d+(?:\.\d+)?)e(-?\d+)(?![\w.])", r"$\1\\times10^{\2}$", escaped)


def markdown(text: str) -> str:
    """Escape text for a Markdown table cell."""
    escaped = re.sub(r"([\\|*_<\[\]])", r"\\\1", text)
    return escaped.replace("\n", " ")
