"""The commands, with their texts and options (commands.toml), without loading any."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Command:
    """What `--help` prints of a command.

    options: in the words of argparse, by their names; of_hydra: whether it takes choices of settings in Hydra's words,
    which its help lists.
    """

    help: str
    example: str
    description: str
    options: Mapping[str, Mapping[str, object]]
    examples: str = ""
    of_hydra: bool = False


_FILE = Path(__file__).with_name("commands.toml")
COMMANDS = {name: Command(**texts) for name, texts in tomllib.loads(_FILE.read_text("utf-8")).items()}
