"""What several commands read from their command line."""

import argparse
from collections.abc import Mapping, Sequence

from repro.errors import UserError

ID = "the id, its beginning, or the digits at its end"


def command_parser(name: str, description: str, examples: str) -> argparse.ArgumentParser:
    """The parser of `repro NAME`; the examples are printed below the options as they are."""
    return argparse.ArgumentParser(
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
    parser.add_argument("--workers", type=int, help="jobs at once (default: one per core that may be used)")


def add_filters(parser: argparse.ArgumentParser) -> None:
    """Add any number of key=value; see `filters` and `fits`."""
    parser.add_argument("filters", nargs="*", metavar="key=value", help="only runs with this value on their card")


def filters(texts: Sequence[str]) -> dict[str, str]:
    """The filters as a dictionary; UserError for a text without an equals sign."""
    for text in texts:
        if "=" not in text:
            raise UserError(f"{text} is no filter: write key=value, e.g. model=lagrangian")
    return dict(text.split("=", 1) for text in texts)


def fits(card: Mapping[str, object], filters: Mapping[str, str]) -> bool:
    """Whether a run's card has all these values; upper and lower case are the same."""
    return all(str(card.get(key, "")).lower() == value.lower() for key, value in filters.items())
