"""What several commands read from their command line."""

import argparse
import math
import re
from collections.abc import Mapping, Sequence
from typing import NoReturn

from repro.errors import UserError
from repro.plugins.plugin import nearest

ID = "the id, its beginning, or the digits at its end"


class CommandParser(argparse.ArgumentParser):
    """A parser whose complaint is one line."""

    def error(self, message: str) -> NoReturn:
        """UserError instead of the usage, with the option that is spelt most alike."""
        options = [option for action in self._actions for option in action.option_strings]
        unknown = re.fullmatch("unrecognized arguments: (.*)", message, re.DOTALL)
        guess = nearest(unknown[1].split()[0], options) if unknown and unknown[1].split() else ""
        raise UserError(f"{message}{guess}; `{self.prog} --help` lists what there is")


def command_parser(name: str, description: str, examples: str) -> argparse.ArgumentParser:
    """The parser of `repro NAME`; the examples are printed below the options as they are."""
    return CommandParser(
        prog=f"repro {name}",
        description=description,
        epilog=examples,
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
    """Add any number of key=value; see `filters` and `fits`."""
    parser.add_argument("filters", nargs="*", metavar="key=value", help="only runs with this value on their card")


def filters(texts: Sequence[str]) -> dict[str, str]:
    """The filters as a dictionary; UserError for a text without an equals sign."""
    for text in texts:
        if "=" not in text:
            raise UserError(f"{text} is no filter: write key=value, e.g. model=lagrangian")
    return dict(text.split("=", 1) for text in texts)


def check_known(filters: Mapping[str, str], cards: Sequence[Mapping[str, object]]) -> None:
    """UserError for a filter by a column that no card has."""
    known = sorted({key for card in cards for key in card})
    for key in filters:
        if known and key not in known:
            raise UserError(f"no column {key}{nearest(key, known)}; there are: {', '.join(known)}")


def fits(card: Mapping[str, object], filters: Mapping[str, str]) -> bool:
    """Whether a run's card has all these values; upper and lower case are the same."""
    return all(str(card.get(key, "")).lower() == value.lower() for key, value in filters.items())
