"""What a report comes to, in plain values: kept beside it, so that an unchanged report is not made again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import TypeAdapter

from repro.claims.verdicts import Verdict, headline
from repro.report.tables.verdicts import in_words
from repro.results.results import Results
from repro.tracking.files import write_text

FILE = "summary.json"


@dataclass(frozen=True)
class Summary:
    """Where a report lies and what it says."""

    scale: str
    folder: Path
    recordings: Path
    headline: str
    verdicts: tuple[Mapping[str, str], ...]  # in words, by name (see `tables.verdicts`)
    runs: int  # finished
    absent: int  # failed and missing
    stale: int
    fingerprint: str = ""  # digest of what it was made from; empty for one that is always made again

    @property
    def page(self) -> Path:
        """The report itself."""
        return self.folder / "index.html"

    @property
    def results(self) -> Path:
        """The result tables."""
        return self.folder / "results"


def summarise(results: Results, verdicts: Sequence[Verdict], folder: Path, recordings: Path) -> Summary:
    """Sum a report up."""
    runs = results.runs.drop_duplicates("run")
    return Summary(
        scale=results.scale,
        folder=folder,
        recordings=recordings,
        headline=headline(verdicts),
        verdicts=tuple(map(in_words, verdicts)),
        runs=int((runs["outcome"] == "ok").sum()),
        absent=int((runs["outcome"] != "ok").sum()),
        stale=int(runs["stale"].fillna(value=False).sum()),
    )


def store_summary(summary: Summary) -> None:
    """Write the summary beside the report."""
    write_text(summary.folder / FILE, TypeAdapter(Summary).dump_json(summary, indent=1).decode())


def stored_summary(folder: Path, recordings: Path, fingerprint: str) -> Summary | None:
    """Return the summary of a report made from the same; None where there is none, or one made from something else."""
    try:
        stored = TypeAdapter(Summary).validate_json((folder / FILE).read_bytes())
    except (OSError, ValueError):
        return None
    summary = replace(stored, folder=folder, recordings=recordings)
    return summary if summary.fingerprint == fingerprint and summary.page.is_file() else None
