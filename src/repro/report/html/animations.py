"""The closed loops in motion, each with its first frame as a still for those who want no motion."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from repro.report.paper import Animation
from repro.tracking.files import replacing


@dataclass(frozen=True)
class ShownAnimation:
    """One animation on the page: file names in its folder of animations, and what is seen."""

    moving: str
    still: str
    title: str
    width: int
    height: int


def copy_animations(animations: Sequence[Animation], source: Path, folder: Path) -> list[ShownAnimation]:
    """Copy the GIF of every animation that was made, and write its first frame beside it, as PNG; return them."""
    made = [(source / f"{each.name}.gif", each.title) for each in animations]
    return [_copied(path, title, folder) for path, title in made if path.is_file()]


def _copied(path: Path, title: str, folder: Path) -> ShownAnimation:
    from PIL import Image

    with replacing(folder / path.name) as temporary:
        shutil.copyfile(path, temporary)
    with Image.open(path) as picture:
        size = picture.size
        with replacing(folder / f"{path.stem}.png", keep_suffix=True) as temporary:
            picture.save(temporary, optimize=True)
    return ShownAnimation(path.name, f"{path.stem}.png", title, *size)
