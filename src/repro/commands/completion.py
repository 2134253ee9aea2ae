"""`repro completion`: what a shell completes after `repro`."""

from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path

from repro.commands.table import COMMANDS
from repro.config import registry
from repro.config.overrides import experiments
from repro.errors import UserError
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.plain_data import flattened

SHELLS = ("bash", "zsh", "fish")  # each has its script beside this file
OF_RUNS = ("show", "diff", "view", "export")
WITH_OVERRIDES = ("run", "identify", "reproduce")


def main(arguments: Namespace) -> int:
    """Print the script for a shell, or with --line what may stand at the end of a line."""
    if arguments.line is not None:
        print("\n".join(candidates(arguments.line)))
        return 0
    if arguments.shell not in SHELLS:
        raise UserError(f"repro completion {arguments.shell or ''}: choose one of {', '.join(SHELLS)}")
    print(Path(__file__).with_suffix(f".{arguments.shell}").read_text(), end="")
    return 0


def candidates(line: str) -> list[str]:
    """What may stand in the place of the last word of a line."""
    *before, word = line.split(" ")
    words = [each for each in before if each][1:]
    return sorted({each for each in _words(words, word) if each.startswith(word)})


def _words(before: Sequence[str], word: str) -> Iterator[str]:
    command = before[0] if before else ""
    if not before:
        yield from COMMANDS
    elif command not in COMMANDS:
        return
    elif word.startswith("-"):
        spelt = (each for words in COMMANDS[command].options for each in words.split())
        yield from ("--help", *(each for each in spelt if each.startswith("-")))
    elif command in OF_RUNS:
        yield from Paths(outputs_root()).ids("runs")
    elif command == "completion":
        yield from SHELLS
    elif command in WITH_OVERRIDES:
        yield from _overrides(before, word)


def _overrides(before: Sequence[str], word: str) -> Iterator[str]:
    key, chosen, value = word.partition("=")
    groups = registry.groups() | {"experiment": experiments()}
    if chosen:
        listed = value.rpartition(",")[0]
        yield from (f"{key}={listed + ',' if listed else ''}{name}" for name in groups.get(key, ()))
    elif (group := key.partition(".")[0]) in groups and "." in key:
        options = [name for name in groups[group] if f"{group}={name}" in before] or groups[group]
        for option in options:
            yield from (f"{group}.{leaf}=" for leaf in flattened(registry.settings(group, option)))
    else:
        yield from (f"{group}=" for group in groups)
        yield from (f"{group}." for group in registry.groups() if key and group.startswith(key))
        yield from ("seeds=", "record=", "device=", "chain=", "whole_chain=")
