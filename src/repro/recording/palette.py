"""Colours of a recording, by role; each stands out from the viewer's dark and its light background alike."""

from collections.abc import Iterable
from itertools import cycle

Colour = tuple[int, int, int]

PLANT: Colour = (62, 134, 234)
FORCE: Colour = (196, 84, 196)
OBSTACLE: Colour = (222, 72, 72)
TRACK: Colour = (132, 132, 132)
PREDICTED: Colour = (226, 160, 40)
BAND: Colour = (150, 150, 150)

MODELS: tuple[Colour, ...] = (
    (226, 104, 10),
    (18, 150, 108),
    (222, 58, 140),
    (136, 114, 222),
    (122, 142, 22),
    (178, 120, 44),
    (22, 146, 168),
    (206, 92, 92),
    (150, 110, 160),
    (92, 142, 92),
)
QUANTITIES: tuple[Colour, ...] = (MODELS[1], PLANT, MODELS[5], MODELS[2], MODELS[3], MODELS[4])


def colours(labels: Iterable[str], choices: tuple[Colour, ...] = MODELS) -> dict[str, Colour]:
    """One colour per label, in order; with more labels the choices repeat."""
    return dict(zip(dict.fromkeys(labels), cycle(choices), strict=False))
