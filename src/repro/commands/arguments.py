"""What several commands read from their command line."""

import argparse
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NoReturn

from repro.commands.table import COMMANDS
from repro.errors import UserError
from repro.plugins.plugin import nearest

if TYPE_CHECKING:
    from repro.tracking.index import Entry

ID = "the id, its beginning, or the digits at its end"


class CommandParser(argparse.ArgumentParser):
    """A parser whose complaint is one line."""

    def error(self, message: str) -> NoReturn:
        """UserError instead of the usage, with the option that is spelt most alike."""
        options = [option for action in self._actions for option in action.option_strings]
        unknown = re.fullmatch("unrecognized arguments: (.*)", message, re.DOTALL)
        guess = nearest(unknown[1].split()[0], options) if unknown and unknown[1].split() else ""
        raise UserError(f"{message}{guess}; `{self.prog} --help` lists what there is")


def command_parser(name: str, more: str = "") -> argparse.ArgumentParser:
    """The parser of `repro NAME` with its texts (commands.toml); below its examples stands what else there is."""
    texts = COMMANDS[name]
    examples = f"examples:\n{texts['examples']}" if "examples" in texts else f"example: repro {name} {texts['example']}"
    return CommandParser(
        prog=f"repro {name}",
        description=texts["description"],
        epilog=examples + more,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add --json, which prints the same content for other programs."""
    parser.add_argument("--json", action="store_true", help="print JSON, for other programs")


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Add --workers, the number of jobs that run at once."""
    parser.add_argument("--workers", type=workers, help="jobs at once (default: one per core that may be used)")


def workers(text: str) -> int:
    """A number of jobs at once, 1 or more."""
    if not re.fullmatch(r"\d{1,6}", text) or not int(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no number of jobs (1 or more)")
    return int(text)


def seconds(text: str) -> float:
    """A time above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is no time in seconds above 0")
    return value


def add_filters(parser: argparse.ArgumentParser) -> None:
    """Add any number of key=value; see `selected`."""
    parser.add_argument("filters", nargs="*", metavar="key=value", help="only runs with this value on their card")


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
