"""The entry point `repro`: finds the command, runs it, and turns the errors of a user into one line."""

from __future__ import annotations

import difflib
import os
import shlex
import sys
from collections.abc import Sequence
from typing import Protocol

from repro.errors import UserError


class Command(Protocol):
    """A module of `repro.commands`: a help line, an example of its arguments, and a function of them."""

    __name__: str
    HELP: str
    EXAMPLE: str

    def main(self, argv: Sequence[str], /) -> int:
        """Run the command and return its exit code."""


def commands() -> dict[str, Command]:
    """The commands by name, in the order of the help. Their modules import heavy libraries only in `main`."""
    from repro.commands import (
        bench,
        clean,
        diff,
        export,
        identify,
        mlflow,
        report,
        reproduce,
        run,
        runs,
        sensitivity,
        show,
        status,
        view,
    )

    results: tuple[Command, ...] = (reproduce, run, sensitivity, status, runs, show, diff, report)
    others: tuple[Command, ...] = (identify, view, export, mlflow, bench, clean)
    return {module.__name__.rpartition(".")[2]: module for module in (*results, *others)}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code: 0 success, 1 failed jobs, 2 a user's mistake, 130 Ctrl-C."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        code = _dispatch(arguments)
        sys.stdout.flush()
        return code
    except UserError as error:
        print(f"repro: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        again = shlex.join(["repro", *arguments])
        print(f"\nStopped. Finished work is kept; to go on: {again}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of the pipe (head, less) has closed it; the interpreter's last flush must not fail on it again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _dispatch(arguments: Sequence[str]) -> int:
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(_help())
        return 0
    if arguments[0] == "--version":
        from importlib.metadata import version

        print(version("repro"))
        return 0
    name, *rest = arguments
    available = commands()
    if name not in available:
        near = difflib.get_close_matches(name, available, n=1)
        guess = f" Did you mean {near[0]}?" if near else ""
        raise UserError(f"no command {name}.{guess} There are: {', '.join(available)}")
    return available[name].main(rest)


def _help() -> str:
    lines = [f"  {name:<11} {one.HELP:<50} repro {name} {one.EXAMPLE}".rstrip() for name, one in commands().items()]
    note = "`repro COMMAND --help` lists its options. Results are in ./outputs, or in the folder $REPRO_OUTPUTS."
    return "\n".join(["usage: repro COMMAND ...", "", *lines, "", note])


if __name__ == "__main__":
    sys.exit(main())
