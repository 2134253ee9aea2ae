"""Finds the recording of a run and opens it: in a window, in a browser, as a picture, or in a page of its own."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import TypeVar

from repro.errors import UserError
from repro.recording.contents import FILENAME
from repro.tracking.load import matching
from repro.tracking.store import Store

Answer = TypeVar("Answer")

KIND = "recordings"
MOST_LISTED = 5  # ids, in a message
LOCAL = "127.0.0.1"
WEB_PORT, DATA_PORT = 9090, 9876
START_SECONDS = 30.0
# The viewer accepts requests before its charts are drawn and its notices have faded.
SETTLE_SECONDS = 8.0
GRAPHICS_HELP = (
    "a picture needs a Vulkan driver; without a graphics card, install a software one (Debian, Ubuntu: "
    "apt-get install mesa-vulkan-drivers)"
)


def find_recording(run: str, root: Path) -> Path:
    """The .rrd file of a path, or of a run's or recording's id under an outputs root, its beginning or last digits."""
    if run.endswith(".rrd"):
        path = Path(run)
        if not path.is_file():
            raise UserError(f"no file {path}")
        return path
    store = Store(root)
    names = {record.id: {record.id, record.identity.upstream.get("run", "")} for record in store.records(KIND)}
    named = set(matching([name for both in names.values() for name in both], run))
    fitting = [id for id, both in names.items() if both & named]
    if len(fitting) == 1:
        return store.paths.folder(KIND, fitting[0]) / FILENAME
    if not names:
        raise UserError(f"no recordings in {root / KIND}; make some with: repro reproduce")
    candidates = sorted(fitting or names)
    more = f" and {len(candidates) - MOST_LISTED} more" if len(candidates) > MOST_LISTED else ""
    listed = ", ".join(candidates[:MOST_LISTED]) + more
    if fitting:
        raise UserError(f"{run!r} fits the ids of {len(fitting)} recordings; type more of one of them: {listed}")
    raise UserError(f"no recording of a run {run!r} in {root / KIND}; there are: {listed}")


def screenshot(path: Path, picture: Path, at: float | None = None, size: tuple[int, int] = (1600, 900)) -> None:
    """Write a PNG of the window at simulated time `at` (s; None: the middle). UserError without a graphics driver."""
    from rerun.experimental import ViewerClient

    from repro.recording.layout import TIMELINE
    from repro.recording.writer import read_recording

    if at is None:
        times = next(track.at for track in read_recording(path).values() if track.timeline == TIMELINE)
        at = float(times[len(times) // 2])
    port = free_port(DATA_PORT)
    window = ["--headless", "--window-size", f"{size[0]}x{size[1]}", "--port", str(port)]
    with _viewer(*window, quiet=True) as process:
        url = f"rerun+http://{LOCAL}:{port}/proxy"
        client = _answer(process, lambda: ViewerClient(url), f"the viewer did not start: {GRAPHICS_HELP}")
        try:
            client.open([str(path.absolute())])
            client.set_time(TIMELINE, duration=at, play_state="paused")
            time.sleep(SETTLE_SECONDS)
            drawn = client.take_screenshot()
        except OSError as error:
            raise UserError(f"the viewer ended before it had drawn ({error}): {GRAPHICS_HELP}") from error
    picture.write_bytes(drawn)


def command_of(*arguments: str) -> list[str]:
    """The command line of the viewer itself, not of the wrapper that would leave it running."""
    name = "rerun.exe" if sys.platform == "win32" else "rerun"
    return [str(files("rerun_cli").joinpath(name)), *arguments]


def environment() -> dict[str, str]:
    """The viewer's environment: errors only, and CI=1, which turns off usage data and the question about it."""
    return {"RUST_LOG": "error", **os.environ, "CI": "1"}


def free_port(first: int) -> int:
    """The first port from `first` on that nothing on this machine listens on."""
    for port in range(first, first + 200):
        with socket.socket() as probe:
            try:
                probe.bind((LOCAL, port))
            except OSError:
                continue
            return port
    raise UserError(f"no free port from {first} to {first + 199}; close some viewers")


def open_window(path: Path) -> int:
    """Open a recording in a window until that is closed; UserError where there is no display."""
    if sys.platform.startswith("linux") and not _has_display():
        raise UserError(
            f"no display here to open a window on; add --web to see it in a browser, --screenshot FILE for a picture, "
            f"or copy {path} to a machine with a display and type: rerun {path.name}"
        )
    with _viewer("--port", "auto", str(path)) as process:
        return _wait(process)


def _has_display() -> bool:
    """Whether a display is named, and the socket of a local one is there."""
    if os.environ.get("WAYLAND_DISPLAY"):
        return True
    display = os.environ.get("DISPLAY", "")
    local = re.match(r"(?:unix)?:(\d+)", display)
    return Path(f"/tmp/.X11-unix/X{local[1]}").exists() if local else bool(display)


def serve(path: Path) -> int:
    """Serve a recording to a browser until Ctrl-C."""
    web, data = free_port(WEB_PORT), free_port(DATA_PORT)
    ports = ["--web-viewer-port", str(web), "--port", str(data)]
    with _viewer("--serve-web", *ports, str(path)) as process:
        print(f"http://{LOCAL}:{web}/?url=rerun%2Bhttp%3A%2F%2F{LOCAL}%3A{data}%2Fproxy")
        print(f"from another machine, first: ssh -L {web}:{LOCAL}:{web} -L {data}:{LOCAL}:{data} HOST")
        print("Ctrl-C stops it", flush=True)
        return _wait(process)


def web_viewer() -> tuple[str, bytes]:
    """Return what a browser needs to show a recording without a server: the viewer's own script and WebAssembly.

    The viewer serves those of its version on this machine for a moment. Raises UserError when it does not start.
    """
    web, data = free_port(WEB_PORT), free_port(DATA_PORT)
    failure = "the viewer did not serve its web pages; is rerun-sdk installed as pinned in constraints.txt?"

    def content(name: str) -> bytes:
        with urllib.request.urlopen(f"http://{LOCAL}:{web}/{name}", timeout=START_SECONDS) as response:
            return bytes(response.read())

    with _viewer("--serve-web", "--web-viewer-port", str(web), "--port", str(data), quiet=True) as process:
        script = _answer(process, partial(content, "re_viewer.js"), failure).decode()
        return script, _answer(process, partial(content, "re_viewer_bg.wasm"), failure)


@contextmanager
def _viewer(*arguments: str, quiet: bool = False) -> Iterator[subprocess.Popen[bytes]]:
    """A viewer that ends with the block; a quiet one opens no browser and does not complain of a missing desktop."""
    output = subprocess.DEVNULL if quiet else None
    browser = {"BROWSER": "true"} if quiet else {}
    command = command_of("--bind", LOCAL, "--hide-welcome-screen", *arguments)
    process = subprocess.Popen(command, env={**environment(), **browser}, stdout=output, stderr=output)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def _answer(process: subprocess.Popen[bytes], request: Callable[[], Answer], failure: str) -> Answer:
    """The answer to a request that fails until the viewer has started; UserError(failure) when it does not start."""
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        try:
            return request()
        except OSError:
            time.sleep(0.1)
    raise UserError(failure)


def _wait(process: subprocess.Popen[bytes]) -> int:
    """Until the viewer is closed, or stopped by Ctrl-C, which is the ordinary way to end it."""
    try:
        return process.wait()
    except KeyboardInterrupt:
        return 0
