"""The commands and their texts, without loading any."""

import tomllib
from pathlib import Path

COMMANDS: dict[str, dict[str, str]] = tomllib.loads(Path(__file__).with_name("commands.toml").read_text("utf-8"))
