"""One look for every figure: colours by role, told apart in grey by lightness, line style and marker, units on axes."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

TEXT_WIDTH = 7.0  # inches
RESOLUTION = 200  # of a figure as PNG, dots per inch


@dataclass(frozen=True)
class Role:
    """How one role is drawn; colours (after Okabe and Ito) differ in lightness too."""

    colour: str
    line: Any
    marker: str
    filled: bool = True

    @property
    def line_style(self) -> dict[str, Any]:
        """Arguments of a line."""
        return {"color": self.colour, "linestyle": self.line}

    @property
    def marker_style(self) -> dict[str, Any]:
        """Arguments of a marker without a line."""
        face = self.colour if self.filled else "white"
        return {"linestyle": "none", "marker": self.marker, "color": self.colour, "markerfacecolor": face}

    @property
    def marked_line_style(self) -> dict[str, Any]:
        """Arguments of a line with markers."""
        return self.marker_style | self.line_style


PLANT = Role("#10305c", "-", "o")
MODEL = Role("#e2680a", (0, (4, 1.5)), "s")
ROLLOUT = Role("#2aa784", (0, (1, 1)), "D")
PAPER = Role("#6b6b6b", (0, (6, 2, 1, 2)), "x")
ANCHOR = Role("#8c8c8c", ":", "|")

ANCHOR_DOT = Role("#8c8c8c", ":", "D", filled=False)

INVERSE = Role("#10305c", "-", "o")
FORWARD = Role("#e2680a", (0, (4, 1.5)), "s", filled=False)

# For what has no role of its own, such as one optimiser among several.
SERIES = (
    INVERSE,
    FORWARD,
    Role("#2aa784", (0, (1, 1)), "D"),
    Role("#b0478f", (0, (6, 2, 1, 2)), "^", filled=False),
    Role("#5aa9e0", (0, (2, 1)), "v"),
    Role("#8a7000", (0, (8, 2)), "P", filled=False),
    Role("#000000", (0, (3, 1, 1, 1, 1, 1)), "X"),
    Role("#f0b400", (0, (5, 1)), "<", filled=False),
    Role("#7a3b12", (0, (8, 2, 2, 2)), ">"),
)


@contextmanager
def applied() -> Iterator[None]:
    """Draw in this style and leave the user's own settings alone."""
    import matplotlib as mpl

    with mpl.rc_context(fname=Path(__file__).with_name("figures.mplstyle")):
        yield
