"""The viewer's own web pages: its program and its WebAssembly, as the installed version serves them."""

import subprocess
import time
import urllib.request
from dataclasses import dataclass

from repro.errors import UserError
from repro.recording.viewer import DATA_PORT, LOCAL, START_SECONDS, WEB_PORT, command_of, environment, free_port


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
    ports = ["--bind", LOCAL, "--web-viewer-port", str(web), "--port", str(data)]
    process = subprocess.Popen(
        command_of("--serve-web", *ports),
        env={**environment(), "BROWSER": "true"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        script = _fetched(process, f"http://{LOCAL}:{web}/re_viewer.js")
        program = _fetched(process, f"http://{LOCAL}:{web}/re_viewer_bg.wasm")
    finally:
        process.terminate()
        process.wait()
    return WebViewer(script.decode(), program)


def _fetched(process: "subprocess.Popen[bytes]", url: str) -> bytes:
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        try:
            with urllib.request.urlopen(url, timeout=START_SECONDS) as answer:
                return bytes(answer.read())
        except OSError:
            time.sleep(0.1)
    raise UserError("the viewer did not serve its web pages; is rerun-sdk installed as pinned in constraints.txt?")
