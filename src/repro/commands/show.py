"""`repro show`: one stored stage in full."""

import sys
from argparse import Namespace
from textwrap import indent

from rich.filesize import decimal

from repro.tracking.load import load_stage
from repro.tracking.paths import RUN_FILE
from repro.tracking.plain_data import flattened
from repro.tracking.store import NOTICES
from repro.tracking.text import duration, short, table


def main(arguments: Namespace) -> int:
    """Print one stage: failure, origin, results, settings and files."""
    entry = load_stage(arguments.id)
    if arguments.json:
        sys.stdout.write(entry.path(RUN_FILE).read_text())
        return 0
    origin = entry.provenance
    print(f"{entry.id}  ({entry.kind}, {entry.outcome})\n  {entry.folder}")
    if entry.failure:
        print(f"\nfailed\n{indent(entry.failure.trace.rstrip(), '  ', lambda line: True)}")
        print(f"  log: {entry.failure.log}" if entry.failure.log else "  log: printed to the terminal")
    print("\nmade by" + (f"\n  {origin.command}" if origin.command else ""))
    print(f"  {origin.finished}, took {duration(origin.wall_s)}, at most {origin.peak_memory_mib} MiB")
    source, machine = origin.git, origin.machine
    print(f"  commit {source['commit']}" + (f", then git apply {source['patch']}" if source.get("patch") else ""))
    print(f"  {machine['processor']}, {machine['platform']}, Python {machine['python']}")
    summary = dict(entry.summary)
    if notices := summary.pop(NOTICES, ()):
        print("\nnotices", *(f"  {notice}" for notice in notices), sep="\n")
    sections = {"results, medians over the members": summary.pop("median", {}), "card": summary.pop("card", {})}
    for title, content in (
        ("from", entry.identity.upstream),
        *((title, flattened(content)) for title, content in sections.items()),
        ("other results", flattened(summary)),
        ("settings of this stage", flattened(entry.identity.config)),
        ("files", {name: decimal(about.bytes) for name, about in entry.files.items()}),
    ):
        if content:
            print(f"\n{title}\n" + table([f"  {key}", short(value)] for key, value in content.items()))
    return 0
