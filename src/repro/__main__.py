"""The entry point `repro`: finds the command, runs it, and turns the errors of a user into one line."""

import difflib
import os
import re
import shlex
import shutil
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module

from repro.commands.table import COMMANDS
from repro.errors import UserError

LONGEST_LINE = 2000  # letters of a message


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code.

    0 success, 1 failed jobs or a failure of the machine, 2 a user's mistake, 130 Ctrl-C.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    _open_closed_streams()
    try:
        try:
            return _dispatch(arguments)
        finally:
            sys.stdout.flush()
    except UserError as error:
        return _end(2, "\n".join(_shortened(line) for line in f"repro: {error}".splitlines()))
    except KeyboardInterrupt:
        again = shlex.join([*program(), *arguments])
        return _end(130, f"\nStopped. Finished work is kept; to go on: {again}")
    except BrokenPipeError:
        _discard_output()
        return 0
    except MemoryError:
        return _end(1, "repro: not enough memory; fewer --workers and data.samples need less. Finished work is kept")
    except OSError as error:
        _discard_output()
        place = f"{error.filename}: " if error.filename else "cannot write the output: " if error.errno else ""
        return _end(1, f"repro: {place}{error.strerror or error}")


def program() -> list[str]:
    """How a user starts this program again: by its name where it is on the path, else as it was started."""
    if shutil.which("repro"):
        return ["repro"]
    called = sys.argv[0]
    return [os.path.relpath(called)] if os.path.basename(called) == "repro" else ["python", "-m", "repro"]  # noqa: PTH119


def _end(code: int, text: str) -> int:
    # Where standard error cannot be written either, the exit code alone says it.
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)
    return code


def _shortened(line: str) -> str:
    words = re.sub(r"\S{300,}", lambda word: f"{word[0][:100]}... ({len(word[0])} letters)", line)
    return words if len(words) <= LONGEST_LINE else f"{words[:LONGEST_LINE]}..."


def _open_closed_streams() -> None:
    """Give a program that was started without standard output or error (`>&-`) one that takes everything."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: PTH123, SIM115 - open until the process ends


def _discard_output() -> None:
    """The interpreter's last flush must not fail again where the reader (head, less) has gone or the disk is full."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _dispatch(arguments: Sequence[str]) -> int:
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(_help())
        return 0
    if arguments[0] == "--version":
        from importlib.metadata import version

        print(version("repro"))
        return 0
    name, *rest = _with_plugins(arguments)
    try:
        os.getcwd()  # noqa: PTH109 - pathlib loads longer
    except FileNotFoundError:
        raise UserError("the working folder was deleted: change to one that exists") from None
    if name not in COMMANDS:
        near = difflib.get_close_matches(name, COMMANDS, n=1)
        guess = f" Did you mean {near[0]}?" if near else ""
        raise UserError(f"no command {name}.{guess} There are: {', '.join(COMMANDS)}")
    from repro.commands.arguments import parsed

    given = parsed(name, rest)
    # imported only now, so that no command waits for the libraries of another
    code: int = import_module(f"repro.commands.{name}").main(given)
    return code


def _with_plugins(arguments: Sequence[str]) -> list[str]:
    """The arguments without `--plugins FOLDER`, which may stand anywhere; its folders are searched from here on."""
    rest, words = [], iter(arguments)
    for word in words:
        if word.split("=")[0] != "--plugins":
            rest.append(word)
            continue
        from repro.plugins.roots import add_root

        folder = word.partition("=")[2] or next(words, "")
        if not folder:
            raise UserError("--plugins: name a folder with models/, mechanics/, conf/, experiments/ or paper/ of yours")
        add_root(folder)
    if not rest:
        raise UserError("--plugins FOLDER goes with a command, such as run")
    return rest


def _help() -> str:
    lines = [f"  {name:<11} {one.help:<50} repro {name} {one.example}".rstrip() for name, one in COMMANDS.items()]
    notes = (
        "`repro COMMAND --help` lists its options. Results are in ./outputs, or in the folder $REPRO_OUTPUTS.",
        "`--plugins FOLDER` (or $REPRO_PLUGINS) adds systems, models, settings and experiments of your own.",
    )
    return "\n".join(["usage: repro COMMAND ...", "", *lines, "", *notes])


if __name__ == "__main__":
    sys.exit(main())
