"""Generated C, compiled once with the machine's compiler and kept on disk."""

import ctypes
import hashlib
import logging
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from filelock import FileLock


class CompilerError(Exception):
    """No C compiler is there, or it refused the source."""


NO_COMPILER = "no C compiler (cc, gcc or clang) was found"


@lru_cache(maxsize=1)
def found_compiler() -> str | None:
    """Path of the C compiler: $CC, cc, gcc or clang; None, with one notice, where there is none."""
    for name in (os.environ.get("CC"), "cc", "gcc", "clang"):
        if name and (path := shutil.which(name)):
            return path
    logging.getLogger("repro").warning("%s: everything works, more slowly", NO_COMPILER)
    return None


def compiler() -> str:
    """Path of the C compiler; CompilerError where there is none."""
    if (path := found_compiler()) is None:
        raise CompilerError(NO_COMPILER)
    return path


def has_compiler() -> bool:
    """Whether generated C can be compiled here."""
    return found_compiler() is not None


def look_up() -> None:
    """Look up what the name of a library needs, for processes that are forked from this one."""
    if has_compiler():
        _version()
        _processor()


def load_library(source: str, flags: Sequence[str]) -> ctypes.CDLL:
    """The shared library of this source, compiled unless it is there; CompilerError with the compiler's words."""
    return ctypes.CDLL(str(library_file(source, flags)))


def library_file(source: str, flags: Sequence[str]) -> Path:
    """Where that library lies, compiled unless it is there."""
    identity = [source, *flags, _version(), _processor()]
    library = cache_folder() / f"{hashlib.sha256(chr(10).join(identity).encode()).hexdigest()[:32]}.so"
    if not library.exists():
        lock = library.with_suffix(".lock")
        with FileLock(lock):  # processes that need one library at once compile it once
            if not library.exists():
                _compile(source, flags, library)
            lock.unlink(missing_ok=True)
    return library


def cache_folder() -> Path:
    """Where compiled libraries are kept: $XDG_CACHE_HOME/repro, ~/.cache/repro, or the temporary folder."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))  # noqa: PTH111 - raises nothing
    folder = home / "repro"
    try:
        if not home.is_absolute():
            raise FileNotFoundError(home)
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        folder = Path(tempfile.gettempdir()) / f"repro-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
    return folder


@lru_cache(maxsize=1)
def _version() -> str:
    return subprocess.run([compiler(), "--version"], capture_output=True, text=True, check=False).stdout


@lru_cache(maxsize=1)
def _processor() -> str:
    # code for the instruction set of one processor may stop another one that shares the cache folder
    information = Path("/proc/cpuinfo")
    lines = information.read_text().splitlines() if information.exists() else []
    return os.uname().machine + next((line for line in lines if line.startswith("flags")), "")


def _compile(source: str, flags: Sequence[str], library: Path) -> None:
    with tempfile.TemporaryDirectory(dir=library.parent) as folder:
        text, unit, built = (Path(folder) / f"generated.{suffix}" for suffix in ("c", "o", "so"))
        text.write_text(source)
        # linked without the flags: -ffast-math at link time would change the rounding mode of the whole process
        for command in (
            [compiler(), *flags, "-fPIC", "-c", str(text), "-o", str(unit)],
            [compiler(), "-shared", str(unit), "-o", str(built), "-lm"],
        ):
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode:
                raise CompilerError(f"{' '.join(command)} failed:\n{done.stderr.strip()}")
        built.replace(library)
