"""What several commands read from their command line."""

import argparse
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from repro.commands.table import COMMANDS
from repro.config.overrides import refuse_options
from repro.config.registry import choices_text
from repro.errors import UserError
from repro.plugins.plugin import nearest

if TYPE_CHECKING:
    from repro.tracking.index import Entry


class _CommandParser(argparse.ArgumentParser):
    """A parser whose complaint is one line."""

    def error(self, message: str) -> NoReturn:
        """UserError instead of the usage, with the option that is spelt most alike."""
        options = [option for action in self._actions for option in action.option_strings]
        unknown = re.fullmatch("unrecognized arguments: (.*)", message, re.DOTALL)
        guess = nearest(unknown[1].split()[0], options) if unknown and unknown[1].split() else ""
        raise UserError(f"{message}{guess}; `{self.prog} --help` lists what there is")


def parsed(name: str, argv: Sequence[str]) -> argparse.Namespace:
    """The arguments of `repro NAME`. UserError for a wrong one."""
    command = COMMANDS[name]
    examples = f"examples:\n{command.examples}" if command.examples else f"example: repro {name} {command.example}"
    if command.of_hydra:
        refuse_options(argv)
        examples += f"\n\nchoices:\n{choices_text()}"
    parser = _CommandParser(
        prog=f"repro {name}",
        description=command.description,
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    exclusive = cache(parser.add_mutually_exclusive_group)
    for words, settings in command.options.items():
        given: Any = {key: TYPES[str(value)] if key == "type" else value for key, value in settings.items()}
        taker = exclusive() if given.pop("exclusive", False) else parser
        taker.add_argument(*words.split(), **given)
    return parser.parse_intermixed_args(argv)


def _workers(text: str) -> int:
    if not re.fullmatch(r"\d{1,6}", text) or not int(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no number of jobs (1 or more)")
    return int(text)


def _seconds(text: str) -> float:
    with suppress(ValueError):
        if 0 < (value := float(text)) < math.inf:
            return value
    raise argparse.ArgumentTypeError(f"{text!r} is no time in seconds above 0")


TYPES = {"float": float, "int": int, "path": Path, "seconds": _seconds, "workers": _workers}


def selected(entries: Iterable["Entry"], filters: Sequence[str]) -> list[tuple["Entry", Mapping[str, object]]]:
    """The entries whose card has all the values of key=value, with it; upper and lower case are the same.

    UserError for a text without an equals sign, and for a column that no card has.
    """
    for text in filters:
        if "=" not in text:
            raise UserError(f"{text} is no filter: write key=value, e.g. model=lagrangian")
    values = dict(text.split("=", 1) for text in filters)
    carded = [(entry, entry.card) for entry in entries]
    known = sorted({key for _, card in carded for key in card})
    for key in values:
        if known and key not in known:
            raise UserError(f"no column {key}{nearest(key, known)}; there are: {', '.join(known)}")
    wanted = {key: value.lower() for key, value in values.items()}
    return [(one, card) for one, card in carded if all(str(card.get(k, "")).lower() == v for k, v in wanted.items())]
