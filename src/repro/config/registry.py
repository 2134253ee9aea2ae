"""What `repro run --help` lists: every group of settings, its options, and the experiments, as their files put it."""

from pathlib import Path

from repro.config.places import CONF, EXPERIMENTS


def choices_text() -> str:
    """A line an option, `group=option` and the first comment of its file."""
    groups = [path for path in sorted(CONF.iterdir()) if path.is_dir()]
    lines = [f"  {f'{group.name}={path.stem}':<38} {_said(path)}" for group in groups for path in _files(group)]
    lines += [f"  {'experiment=' + path.stem:<38} {_said(path)}" for path in _files(EXPERIMENTS)]
    lines += [
        f"  {line.split('#')[0].strip().replace(': ', '='):<38} {line.split('#')[1].strip()}" for line in _plain()
    ]
    return "\n".join(lines)


def _files(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.yaml"))


def _said(path: Path) -> str:
    """The first comment that is no command line."""
    comments = [line.partition("#")[2].strip() for line in path.read_text().splitlines() if "#" in line]
    return next((comment for comment in comments if not comment.startswith("repro ")), "")


def _plain() -> list[str]:
    """The keys outside all groups that are for users to choose."""
    lines = (CONF / "config.yaml").read_text().splitlines()
    return [line for line in lines if line[:1].isalpha() and "#" in line and "set by" not in line]
