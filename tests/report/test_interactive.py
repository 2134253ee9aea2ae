"""The page that holds the viewer: it plays a recording from disk, and speaks with nobody."""

import os
import shutil

import numpy as np
import pytest

from repro.commands import report as command
from repro.commands.arguments import parsed
from repro.errors import UserError
from repro.report.html.interactive import write_interactive

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


@pytest.mark.slow
@pytest.mark.extras
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed (Debian, Ubuntu: apt-get install chromium)")
def test_the_viewer_starts_from_disk_and_draws(tmp_path):
    playwright = pytest.importorskip("playwright.sync_api", reason="pip install -e '.[browser]'")
    rerun = pytest.importorskip("rerun")
    path = tmp_path / "sip-a" / "recording.rrd"
    path.parent.mkdir()
    with rerun.RecordingStream("repro", recording_id="sip-a") as stream:
        stream.save(path)
        stream.log("picture", rerun.Image(np.full((64, 64, 3), (255, 0, 0), dtype=np.uint8)), static=True)
    page_file = write_interactive([path], tmp_path)
    assert page_file.stat().st_size < 25e6

    flags = [*FLAGS, "--no-sandbox"] if os.geteuid() == 0 else FLAGS
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=flags)
        page = browser.new_page(viewport={"width": 800, "height": 600})
        answered: list[str] = []
        page.on("response", lambda response: answered.append(response.url))
        page.goto(page_file.as_uri())
        page.locator("#state").wait_for(state="hidden", timeout=120_000)
        red = 0
        for _ in range(60):
            page.wait_for_timeout(1000)
            red = _red(page.screenshot())
            if red > 1000:
                break
        browser.close()
    assert red > 1000, "the red picture of the recording is on the screen"
    assert all(url.startswith(("file:", "blob:", "data:")) for url in answered)


def _red(png: bytes) -> int:
    """Number of pixels that are red."""
    import io

    from PIL import Image

    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
    return int(((pixels[..., 0] > 200) & (pixels[..., 1:].max(-1) < 60)).sum())


def test_an_unknown_run_is_refused_before_any_work(quick_store, monkeypatch):
    quick_store.run("sip_basis", {"mae_tau": [0.2, 0.3]})
    monkeypatch.setenv("REPRO_OUTPUTS", str(quick_store.outputs))
    with pytest.raises(UserError, match="no recordings"):
        command.main(parsed("report", ["--interactive", "sip-nothing"]))
    assert not (quick_store.outputs / "report").exists()
