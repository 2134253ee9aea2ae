"""Links that leave docs/ work in the repository and on the site: what they point to becomes part of the site.

README.md is the home page, Markdown files become pages, pictures and settings are copied as they are.
"""

import posixpath
import re
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
HOME = "README.md"
LINK = re.compile(r"(?<=\]\()[^)\s]+(?=[)\s])")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the home page, and whatever the pages link to outside of docs/."""
    files.append(_generated("index.md", ROOT / HOME, config))
    waiting = [ROOT / HOME, *sorted((ROOT / "docs").rglob("*.md"))]
    for page in waiting:
        for target in _targets(page):
            outside = target != ROOT / HOME and not target.is_relative_to(ROOT / "docs")
            if outside and target.is_file() and files.get_file_from_path(_uri(target)) is None:
                files.append(_generated(_uri(target), target, config))
                if target.suffix == ".md":
                    waiting.append(target)
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Turn links between files of the repository into links between pages of the site."""
    here = page.file.src_uri
    source = ROOT / HOME if here == "index.md" else _source(here)

    def relinked(match: re.Match[str]) -> str:
        link = urlsplit(match[0])
        if link.scheme or link.netloc or not link.path:
            return match[0]
        target = posixpath.relpath(_uri((source.parent / link.path).resolve()), posixpath.dirname(here) or ".")
        return f"{target}#{link.fragment}" if link.fragment else target

    return LINK.sub(relinked, markdown)


def _targets(page: Path) -> list[Path]:
    links = (urlsplit(link) for link in LINK.findall(page.read_text(encoding="utf-8")))
    return [(page.parent / link.path).resolve() for link in links if link.path and not link.scheme]


def _uri(path: Path) -> str:
    """Where a file of the repository lies on the site, as mkdocs names sources."""
    if path == ROOT / HOME:
        return "index.md"
    base = ROOT / "docs" if path.is_relative_to(ROOT / "docs") else ROOT
    return path.relative_to(base).as_posix()


def _source(uri: str) -> Path:
    inside = ROOT / "docs" / uri
    return inside if inside.is_file() else ROOT / uri


def _generated(uri: str, path: Path, config: MkDocsConfig) -> File:
    return File.generated(config, uri, abs_src_path=str(path))
