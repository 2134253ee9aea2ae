"""The closed loops in motion, each with its first frame as a still for those who want no motion."""

import shutil
from dataclasses import dataclass
from pathlib import Path

from repro.tracking.files import replacing

TITLES = {
    "sip_swing_up": "One link swings up past the disc and is held there.",
    "dip_swing_up": "Two links swing up past the disc and are held there.",
}


@dataclass(frozen=True)
class Animation:
    """One animation: file names in the folder of animations, and what is seen."""

    moving: str
    still: str
    title: str
    width: int
    height: int


def copy_animations(source: Path, folder: Path) -> list[Animation]:
    """Copy every GIF and write its first frame beside it, as PNG; return them."""
    return [_copied(path, folder) for path in sorted(source.glob("*.gif"), reverse=True)]


def _copied(path: Path, folder: Path) -> Animation:
    from PIL import Image

    with replacing(folder / path.name) as temporary:
        shutil.copyfile(path, temporary)
    with Image.open(path) as picture:
        size = picture.size
        with replacing(folder / f"{path.stem}.png", keep_suffix=True) as temporary:
            picture.save(temporary, optimize=True)
    title = TITLES.get(path.stem, path.stem.replace("_", " "))
    return Animation(path.name, f"{path.stem}.png", title, *size)
