"""The entry point `repro`: finds the command, runs it, and turns the errors of a user into one line."""

import difflib
import os
import shlex
import sys
from collections.abc import Sequence
from importlib import import_module

from repro.errors import UserError

COMMANDS = {  # by name: a line of help, and an example of the arguments
    "reproduce": ("run every experiment and make the report", "scale=quick"),
    "run": ("run one configuration, or many with -m", "-m basis=t1,t2"),
    "sensitivity": ("change one assumption at a time", "data_start"),
    "status": ("what is done, stale, failed, missing", "--why 9f3c2a81bd"),
    "runs": ("list stored runs", "basis=t2"),
    "show": ("one run in full", "9f3c2a81bd"),
    "diff": ("how two runs differ", "9f3c2a81bd 04be7d1f6a"),
    "report": ("make tables, figures and verdicts from stored runs", ""),
    "identify": ("which terms of a linear basis data determine", "system=dip basis=fxf"),
    "view": ("open a run's recording, or several in one", "9f3c2a81bd 04be7d1f6a"),
    "export": ("a learned model for CasADi, C and torch", "9f3c2a81bd exported"),
    "mlflow": ("copy finished runs to an MLflow tracking store", "sqlite:///mlflow.db basis=t2"),
    "bench": ("time this project against others", ""),
    "clean": ("remove leftovers, never a current result", "--yes"),
}


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
    if name not in COMMANDS:
        near = difflib.get_close_matches(name, COMMANDS, n=1)
        guess = f" Did you mean {near[0]}?" if near else ""
        raise UserError(f"no command {name}.{guess} There are: {', '.join(COMMANDS)}")
    # imported only now, so that no command waits for the libraries of another
    code: int = import_module(f"repro.commands.{name}").main(rest)
    return code


def _help() -> str:
    lines = [f"  {name:<11} {text:<50} repro {name} {words}".rstrip() for name, (text, words) in COMMANDS.items()]
    note = "`repro COMMAND --help` lists its options. Results are in ./outputs, or in the folder $REPRO_OUTPUTS."
    return "\n".join(["usage: repro COMMAND ...", "", *lines, "", note])


if __name__ == "__main__":
    sys.exit(main())
