"""The pages as files: sound markup, every link and picture there, nothing from elsewhere."""

import html.parser
import itertools
import re
from pathlib import Path
from urllib.parse import unquote, urlsplit

import html5lib
import pytest

from repro.claims.claims import load_claims
from repro.report.build import build
from repro.tracking.paths import project_folder

ROOT = project_folder()


class Page(html.parser.HTMLParser):
    """What a page refers to, what it can be referred to by, and what it says of itself."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path
        self.ids: list[str] = []
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = path.read_text(encoding="utf-8")
        self.feed(self.text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.tags.append((tag, values))
        if values.get("id"):
            self.ids.append(values["id"])
        if tag == "a":
            self.links.append(values["href"])
        self.loaded += [values[name] for name in ("src", "srcset", "data-still") if values.get(name)]
        if tag == "link" and values["href"] != "data:,":
            self.loaded.append(values["href"])

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [values for name, values in self.tags if name == tag]


@pytest.fixture(scope="module")
def pages(built) -> dict[Path, Page]:
    return {path: Page(path) for path in [built.page, *built.folder.glob("claims/*"), *built.folder.glob("runs/*")]}


def test_every_claim_and_every_run_has_its_page(built, pages):
    claims = {claim.name for claim in load_claims(ROOT / "paper" / "claims.yaml")}
    assert {path.stem for path in built.folder.glob("claims/*")} == claims
    assert len(list(built.folder.glob("runs/*"))) >= built.runs + built.absent


def test_every_link_leads_somewhere(pages):
    for page in pages.values():
        for link in {*page.links, *page.loaded}:
            parts = urlsplit(link)
            assert not parts.scheme and not parts.netloc, link
            target = (page.path.parent / unquote(parts.path)).resolve() if parts.path else page.path
            assert target.is_file(), f"{page.path.name}: {link}"
            if parts.fragment:
                assert parts.fragment in pages[target].ids, f"{page.path.name}: {link}"


def test_nothing_comes_from_elsewhere(built, pages):
    texts = [page.text for page in pages.values()]
    texts += [path.read_text(encoding="utf-8") for path in built.folder.glob("assets/*")]
    assert not any(re.search(r"https?:|@import|url\(", text) for text in texts)


def test_the_markup_is_valid(built, pages):
    some = [built.page, *sorted(pages)[1::9]]
    for path in some:
        html5lib.HTMLParser(strict=True).parse(pages[path].text)
    for page in pages.values():
        assert len(page.ids) == len(set(page.ids)), page.path


def test_the_pages_can_be_read_without_seeing_them(pages):
    for page in pages.values():
        assert page.all("html")[0]["lang"] == "en"
        assert len(page.all("h1")) == len(page.all("main")) == 1
        levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h\d", tag)]
        assert all(after <= before + 1 for before, after in itertools.pairwise(levels)), page.path
        assert all(values["alt"] for values in page.all("img"))
        assert all(values.get("scope") for values in page.all("th"))
        assert len(page.all("caption")) == len(page.all("table"))
        assert all(values["aria-label"] and values["tabindex"] == "0" for values in page.all("div") if "role" in values)


def test_a_number_leads_to_its_run_and_the_run_back_to_its_claims(built, pages):
    claim = pages[built.folder / "claims" / "C4a.html"]
    (run,) = {link for link in claim.links if link.startswith("../runs/")}
    assert "achieved MAE_tau = 0.26" in claim.text
    assert "one more falls within" in claim.text
    card = pages[(claim.path.parent / run).resolve()]
    assert "../claims/C4a.html" in card.links
    assert f"runs/{card.path.name}" in pages[built.page].links
    assert "repro run basis=t2" in card.text
    for metric in ("mae_tau", "mae_H_legendre"):
        assert metric in card.text
    assert f"repro view {card.path.stem}" in card.text


@pytest.mark.usefixtures("pages_only")
def test_a_failed_run_shows_why(quick_store):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]}, status=["ok", "diverged <early>"])
    quick_store.run("sip_basis", {}, seeds=[0], outcome="failed", basis="raw")
    cards = [path.read_text(encoding="utf-8") for path in build(quick_store.outputs, "quick").folder.glob("runs/*")]
    assert any("MemoryError: no room" in text for text in cards)
    assert any("seed 1: diverged &lt;early&gt;" in text and "1 of 2 members" in text for text in cards)
