"""The pages in a browser, opened from disk: what filters, sorts, folds and fits (Chromium and the extra `browser`)."""

import os
import shutil

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

pytestmark = [
    pytest.mark.extras,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed (Debian, Ubuntu: apt-get install chromium)"),
]

PHONE = {"width": 390, "height": 844}
SHOWN = "rows => rows.filter(row => row.checkVisibility()).map(row => row.id)"


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="pip install -e '.[browser]'")
    flags = ["--disable-gpu", "--disable-quic", "--disable-background-networking", "--disable-component-update"]
    flags += ["--no-sandbox"] if os.geteuid() == 0 else []
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=flags)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def addresses(built):
    card = sorted(built.folder.glob("runs/*"))[0]
    return [path.as_uri() for path in (built.page, built.folder / "claims" / "C4a.html", card)]


@pytest.fixture
def front(browser, addresses):
    page = browser.new_page()
    page.goto(addresses[0])
    yield page
    page.close()


def shown(page) -> list[str]:
    return page.eval_on_selector_all("#verdict-table tbody tr", SHOWN)


def column(page, number: int) -> list[str]:
    cells = page.locator(f"#verdict-table tbody tr > :nth-child({number})")
    return [text.split()[0] if text.split() else "" for text in cells.all_inner_texts()]


def test_the_pages_load_without_a_complaint_and_ask_nobody(browser, addresses):
    page = browser.new_page()
    complaints: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("requestfailed", lambda request: complaints.append(request.url))
    page.on("request", lambda request: asked.append(request.url))
    for address in addresses:
        page.goto(address, wait_until="networkidle")
    page.close()
    assert complaints == []
    assert all(url.startswith(("file:", "data:")) for url in asked)


def test_the_filters_narrow_the_table_and_say_how_far(front):
    every = shown(front)
    assert len(every) > 50
    front.select_option("select[name=claim]", "C4")
    assert shown(front) == ["C4a", "C4b"]
    assert front.locator("output").inner_text() == f"2 of {len(every)} shown"
    front.fill("input[name=text]", "raw L")
    assert shown(front) == ["C4b"]
    front.click("text=Show all")
    front.wait_for_function("document.querySelectorAll('#verdict-table tr[hidden]').length === 0")
    front.select_option("select[name=verdict]", "not run")
    assert all("not run" in text for text in front.locator("#verdict-table tbody tr:visible").all_inner_texts())
    front.click(".counts a[data-verdict=consistent]")
    assert front.locator("select[name=verdict]").input_value() == "consistent"
    counted = front.locator(".counts a[data-verdict=consistent] b").inner_text()
    assert len(shown(front)) == int(counted)


def test_a_link_to_a_row_shows_it_whatever_is_filtered(front):
    front.select_option("select[name=claim]", "C4")
    front.evaluate("location.hash = '#C1a'")
    front.wait_for_selector("#C1a", state="visible")


def test_columns_sort_by_size_with_what_is_absent_last(front):
    front.get_by_role("button", name="printed", exact=True).first.click()
    numbers = column(front, 4)
    present = [float(text) for text in numbers if text != "–"]
    assert present == sorted(present) and len(present) > 5
    assert set(numbers[len(present) :]) == {"–"}
    head = front.get_by_role("columnheader", name="printed", exact=True)
    assert head.get_attribute("aria-sort") == "ascending"
    front.get_by_role("button", name="printed", exact=True).first.press("Enter")
    assert head.get_attribute("aria-sort") == "descending"
    again = [float(text) for text in column(front, 4) if text != "–"]
    assert again == sorted(again, reverse=True)
    front.get_by_role("button", name="claim", exact=True).first.click()
    names = column(front, 1)
    assert names.index("C2") < names.index("C10")


def test_without_javascript_everything_can_be_read(browser, addresses):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(addresses[0])
    rows = page.locator("#verdict-table tbody tr")
    assert rows.count() == page.locator("#verdict-table tbody tr:visible").count() > 50
    assert page.locator("form:visible, button:visible").count() == 0
    context.close()


@pytest.mark.parametrize("size", [PHONE, {"width": 1280, "height": 900}], ids=["phone", "desktop"])
def test_no_page_is_wider_than_the_window(browser, addresses, size):
    page = browser.new_page(viewport=size)
    for address in addresses:
        page.goto(address)
        page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"], address
    page.close()


def test_the_keyboard_reaches_the_content_first(front):
    front.keyboard.press("Tab")
    assert front.evaluate("document.activeElement.className") == "skip"
    assert front.locator(".skip").bounding_box()["x"] >= 0
    front.keyboard.press("Enter")
    assert front.url.endswith("#content")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_stand_out_from_the_page(browser, addresses, scheme):
    page = browser.new_page(color_scheme=scheme)
    page.goto(addresses[0])
    behind = luminance(page, "body", "backgroundColor")
    for selector in ("body", "a", "small", ".verdict", ".consistent", ".supported", ".not-run", ".too-few", ".outside"):
        for element in page.locator(f"main {selector}" if selector != "body" else "body").all()[:3]:
            front = luminance(element, None, "color")
            light, dark = max(front, behind), min(front, behind)
            assert (light + 0.05) / (dark + 0.05) >= 4.5, selector
    page.close()


def luminance(where, selector, style) -> float:
    """Relative luminance of a colour as WCAG 2 defines it."""
    script = f"element => getComputedStyle(element).{style}"
    text = where.eval_on_selector(selector, script) if selector else where.evaluate(script)
    parts = [int(part) / 255 for part in text[text.index("(") + 1 : -1].split(",")[:3]]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_motion_is_held_for_those_who_want_none(browser, addresses):
    page = browser.new_page(reduced_motion="reduce")
    page.goto(addresses[0])
    image = page.locator("img[data-still]").first
    assert image.get_attribute("src").endswith(".png")
    page.locator("figure button").first.click()
    assert image.get_attribute("src").endswith(".gif")
    page.close()


def test_a_command_can_be_copied_or_is_at_least_selected(browser, addresses):
    page = browser.new_page()
    page.goto(addresses[1])
    button = page.locator(".command button").first
    button.click()
    page.wait_for_function("document.querySelector('.command button').textContent !== 'copy'")
    if button.inner_text() == "selected":
        assert page.evaluate("getSelection().toString()") == page.locator(".command code").first.inner_text()
    page.close()


def test_what_is_folded_is_printed(front):
    assert front.locator("details:not([open])").count() > 0
    front.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert front.locator("details:not([open])").count() == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1400])
def test_every_verdict_is_visible_beside_its_claim(browser, addresses, width, scheme):
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
    page = context.new_page()
    page.goto(addresses[0])
    edges = "cells => cells.map(cell => cell.getBoundingClientRect()).map(box => [box.left, box.right])"
    for cells in ("#verdict-table tbody .verdict", "#verdict-table tbody th a"):
        assert all(0 <= left < right <= width for left, right in page.eval_on_selector_all(cells, edges))
    context.close()


def test_the_front_page_is_short_and_a_link_opens_what_it_leads_to(front):
    assert front.locator("details.chapter[open]").count() == 0
    assert front.evaluate("document.documentElement.scrollHeight") < 8000
    front.evaluate("location.hash = '#assumptions'")
    front.wait_for_selector("#assumptions .ledger", state="visible")


def test_a_table_that_is_wider_than_its_box_says_so(browser, addresses):
    page = browser.new_page(viewport=PHONE)
    page.goto(addresses[0])
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    page.wait_for_function("[...document.querySelectorAll('.sideways')].some(sign => !sign.hidden)")
    wide = "signs => signs.map(sign => [sign.hidden, sign.previousElementSibling])"
    wide += ".every(([hidden, box]) => hidden === (box.scrollWidth <= box.clientWidth + 1))"
    assert page.eval_on_selector_all(".sideways", wide)
    page.close()
