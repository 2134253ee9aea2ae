"""The groups of settings and their options as their files hold them, and the list that `repro run --help` shows."""

from functools import cache
from pathlib import Path
from typing import Any

from repro.config.places import CONF, check_checkout, experiment_files, option_file, settings_roots
from repro.errors import UserError
from repro.tracking.files import read_yaml


@cache
def groups() -> dict[str, list[str]]:
    """Every group with its options. A file whose name begins with _ is a base of others, no option."""
    check_checkout()
    names = sorted(path.name for path in CONF.iterdir() if path.is_dir())
    folders = {name: [root / CONF.name / name for root in settings_roots()] for name in names}
    files = {name: [path for each in folders[name] for path in sorted(each.glob("[!_]*.yaml"))] for name in names}
    return {name: list(dict.fromkeys(path.stem for path in files[name])) for name in names}


@cache
def settings(group: str, option: str) -> dict[str, Any]:
    """The keys of an option with their values, those of its base included; UserError for a file that is no YAML."""
    own = read_settings(option_file(group, option))
    whole: dict[str, Any] = {}
    for layer in own.get("defaults", ["_self_"]):
        whole = merged(whole, own if layer == "_self_" else settings(group, layer))
    return {key: value for key, value in whole.items() if key != "defaults"}


@cache
def read_settings(path: Path) -> dict[str, Any]:
    """The content of a file of settings; UserError for one that is no YAML."""
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise UserError(f"{path} must hold `key: value` lines")
    return content


def choices_text() -> str:
    """One line per option: `group=option` and the first comment of its file."""
    lines = [(f"{group}={name}", _comment(option_file(group, name))) for group in groups() for name in groups()[group]]
    lines += [(f"experiment={name}", _comment(path)) for name, path in experiment_files().items()]
    for line in (CONF / "config.yaml").read_text().splitlines():  # the keys outside all groups that users choose
        setting, sign, comment = line.partition("#")
        if line[:1].isalpha() and sign and "set by" not in line:
            lines.append((setting.strip().replace(": ", "="), comment.strip()))
    return "\n".join(f"  {choice:<38} {comment}" for choice, comment in lines)


def merged(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Dictionaries merged key by key, as Hydra composes them."""
    result = dict(base)
    for key, value in changes.items():
        nested = isinstance(value, dict) and isinstance(result.get(key), dict)
        result[key] = merged(result[key], value) if nested else value
    return result


def _comment(path: Path) -> str:
    """The first comment that is no command line."""
    comments = [line.partition("#")[2].strip() for line in path.read_text().splitlines() if "#" in line]
    return next((comment for comment in comments if not comment.startswith("repro ")), "")
