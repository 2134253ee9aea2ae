"""The commands of the front door that look into stages: show, diff."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from repro.errors import UserError
from repro.tracking import record, status
from repro.tracking.files import flattened
from repro.tracking.paths import RUN_FILE, Paths, outputs_root
from repro.tracking.record import Record
from repro.tracking.text import duration, short, size, table

if TYPE_CHECKING:
    from repro.tracking.diff import Difference

_LINE = 100


def show(argv: Sequence[str]) -> int:
    """`repro show ID`: one stage in full."""
    parser = argparse.ArgumentParser(
        prog="repro show",
        description="Show one stored stage: settings, results, where it comes from, its files, its failure.",
        epilog="example: repro show 9f3c2a81bd",
    )
    parser.add_argument("id", help="the id, its start, or the digits at its end")
    parser.add_argument("--json", action="store_true", help="run.json as it is")
    options = parser.parse_args(argv)
    entry = _record(Paths(outputs_root()), options.id)
    if options.json:
        sys.stdout.write(entry.path(RUN_FILE).read_text())
        return 0
    origin = entry.provenance
    print(f"{entry.id}  ({entry.kind}, {entry.outcome})\n  {entry.folder}")
    if entry.error:
        print(f"\nfailed\n{_indented(entry.error['trace'])}")
        print(f"  log: {entry.error['log']}" if entry.error["log"] else "  log: printed to the terminal")
    print("\nmade by" + (f"\n  {origin['command']}" if origin["command"] else ""))
    print(f"  {origin['finished']}, took {duration(origin['wall_s'])}, at most {origin['peak_memory_mib']} MiB")
    source, machine = origin["git"], origin["machine"]
    print(f"  commit {source['commit']}" + (f", then git apply {source['patch']}" if source.get("patch") else ""))
    print(f"  {machine['processor']}, {machine['platform']}, Python {machine['python']}")
    summary = dict(entry.summary)
    sections = {"results, medians over the members": summary.pop("median", {}), "card": summary.pop("card", {})}
    for title, content in (
        ("from", entry.identity["upstream"]),
        *((title, flattened(content)) for title, content in sections.items()),
        ("also told", flattened(summary)),
        ("settings of this stage", flattened(entry.identity["config"])),
        ("files", {name: size(about["bytes"]) for name, about in entry.files.items()}),
    ):
        if content:
            print(f"\n{title}\n" + table([f"  {key}", short(value)] for key, value in content.items()))
    return 0


def diff(argv: Sequence[str]) -> int:
    """`repro diff A B`: how two stages differ."""
    parser = argparse.ArgumentParser(
        prog="repro diff",
        description="How two stored stages differ: settings, code, libraries, origin, results, and their sources' too.",
        epilog="example: repro diff 9f3c2a81bd 04be7d1f6a",
    )
    parser.add_argument("before", help="an id, its start, or the digits at its end")
    parser.add_argument("after")
    parser.add_argument("--json", action="store_true", help="for other programs")
    options = parser.parse_args(argv)
    from repro.tracking.diff import record_differences
    from repro.tracking.store import Store

    paths = Paths(outputs_root())
    found = record_differences(Store(paths.root), _record(paths, options.before), _record(paths, options.after))
    if options.json:
        print(json.dumps([asdict(one) for one in found], indent=1))
        return 0
    for area in dict.fromkeys(one.area for one in found):
        print(area)
        own = [one for one in found if one.area == area]
        for one in filter(_is_long, own):
            print(f"  {one.key}\n    {one.before}\n    {one.after}")
        if brief := [_sides(one) for one in own if not _is_long(one)]:
            print(table(brief))
    if not found:
        print("They do not differ.")
    return 0


def _is_long(one: Difference) -> bool:
    """Whether the two sides read better below each other."""
    return not one.area.endswith("code") and len(f"{one.key}{one.before}{one.after}") > _LINE


def _sides(one: Difference) -> list[str]:
    """What differs, before and after; of code there is no more to say than that it changed."""
    if one.area.endswith("code"):
        return [f"  {one}"]
    return [f"  {one.key}", short(one.before), "->", short(one.after)]


def _record(paths: Paths, text: str) -> Record:
    folder = status.resolve(paths, text)
    try:
        return record.read(folder)
    except record.Damage as damage:
        raise UserError(f"{folder} is damaged ({damage}); the command that made it makes it again") from damage


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.rstrip().splitlines())
