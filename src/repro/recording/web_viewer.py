"""The viewer's own web pages: its program and its WebAssembly, as the installed version serves them."""

import urllib.request
from dataclasses import dataclass

from repro.recording.viewer import DATA_PORT, LOCAL, START_SECONDS, WEB_PORT, answer, free_port, running_viewer


@dataclass(frozen=True)
class WebViewer:
    """What a browser needs to show a recording without a server."""

    script: str
    program: bytes


def web_viewer() -> WebViewer:
    """Fetch both files from the viewer, which serves them on this machine for a moment.

    Raises UserError when it does not start.
    """
    web, data = free_port(WEB_PORT), free_port(DATA_PORT)
    failure = "the viewer did not serve its web pages; is rerun-sdk installed as pinned in constraints.txt?"
    ports = ["--web-viewer-port", str(web), "--port", str(data)]
    with running_viewer("--serve-web", *ports, quiet=True) as process:

        def fetched(name: str) -> bytes:
            return answer(process, lambda: _content(f"http://{LOCAL}:{web}/{name}"), failure)

        return WebViewer(fetched("re_viewer.js").decode(), fetched("re_viewer_bg.wasm"))


def _content(url: str) -> bytes:
    with urllib.request.urlopen(url, timeout=START_SECONDS) as response:
        return bytes(response.read())
