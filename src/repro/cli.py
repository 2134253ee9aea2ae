"""The front door: finds the command, imports nothing else, and ends calmly."""

from __future__ import annotations

import difflib
import os
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec

from repro.errors import UserError


@dataclass(frozen=True)
class Command:
    """A word after `repro`, and the function(argv) -> exit code behind it."""

    name: str
    help: str
    example: str
    target: str


COMMANDS = (
    Command(
        "reproduce",
        "run every experiment and make the report",
        "reproduce scale=quick",
        "repro.commands.reproduce:reproduce",
    ),
    Command("run", "run one configuration, or many with -m", "run -m basis=t1,t2", "repro.commands.run:run"),
    Command(
        "sensitivity",
        "change one assumption at a time",
        "sensitivity data_start",
        "repro.commands.sensitivity:main",
    ),
    Command(
        "status", "what is done, stale, failed, missing", "status --why 9f3c2a81bd", "repro.commands.status:status"
    ),
    Command("runs", "list stored runs", "runs basis=t2", "repro.commands.runs:runs"),
    Command("show", "one run in full", "show 9f3c2a81bd", "repro.commands.show:show"),
    Command("diff", "how two runs differ", "diff 9f3c2a81bd 04be7d1f6a", "repro.commands.diff:diff"),
    Command("report", "make tables, figures and verdicts from stored runs", "report", "repro.commands.report:main"),
    Command(
        "identify",
        "what data can tell of a linear basis",
        "identify system=dip basis=fxf sequence=pretrain",
        "repro.commands.identify:main",
    ),
    Command(
        "view", "open a run's recording, or several in one", "view 9f3c2a81bd 04be7d1f6a", "repro.commands.view:main"
    ),
    Command(
        "export", "a learned model for CasADi, C and torch", "export 9f3c2a81bd exported", "repro.commands.export:main"
    ),
    Command(
        "mlflow",
        "copy finished runs to an MLflow tracking store",
        "mlflow sqlite:///mlflow.db basis=t2",
        "repro.commands.mlflow:main",
    ),
    Command("bench", "time this project against others", "bench", "repro.commands.bench:main"),
    Command("clean", "remove leftovers, never a current result", "clean --yes", "repro.commands.clean:clean"),
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code: 0 well, 1 failed jobs, 2 a user's mistake, 130 Ctrl-C."""
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
        # The reader (head, less) has left; what it did not read goes nowhere, without complaint.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _dispatch(arguments: list[str]) -> int:
    commands = {command.name: command for command in COMMANDS if _exists(command)}
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(_help(commands))
        return 0
    if arguments[0] == "--version":
        from importlib.metadata import version

        print(version("repro"))
        return 0
    name, *rest = arguments
    if name not in commands:
        near = difflib.get_close_matches(name, commands, n=1)
        guess = f" Did you mean {near[0]}?" if near else ""
        raise UserError(f"no command {name}.{guess} There are: {', '.join(commands)}")
    module, _, function = commands[name].target.partition(":")
    return int(getattr(import_module(module), function)(rest))


def _exists(command: Command) -> bool:
    try:
        return find_spec(command.target.partition(":")[0]) is not None
    except ModuleNotFoundError:
        return False


def _help(commands: dict[str, Command]) -> str:
    lines = ["usage: repro COMMAND ...", ""]
    lines += [f"  {name:<11} {command.help:<50} repro {command.example}" for name, command in commands.items()]
    lines += [
        "",
        "`repro COMMAND --help` says more. Results lie in ./outputs, or where REPRO_OUTPUTS says.",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
