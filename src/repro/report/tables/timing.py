"""The table of paired timings."""

from repro.report import writing
from repro.report.tables.table import Row, Table
from repro.results.results import Results
from repro.results.table_schema import as_text, plain

COLUMNS = (
    *("comparison", "ours", "other", "size", "members", "other / ours (quartiles)"),
    *("ours [ms]", "other [ms]", "threads", "protocol"),
)
CAPTION = "Paired and interleaved timings on one machine: a ratio above 1 says that ours is faster."


def timing_table(results: Results) -> Table:
    """Make the table of paired timings."""
    rows = []
    for bench in results.bench.to_dict("records"):
        text = {str(key): as_text(plain(value)) for key, value in bench.items()}
        quartiles = f"[{writing.number(bench['ratio_q25'])}, {writing.number(bench['ratio_q75'])}]"
        rows.append(
            Row(
                cells=(
                    *(text[key] for key in ("name", "ours", "other", "size", "members")),
                    f"{writing.number(bench['ratio_median'])} {quartiles}",
                    *(writing.number(bench[key]) for key in ("ours_ms", "other_ms")),
                    *(text[key] for key in ("threads", "protocol")),
                ),
                data={str(key): value for key, value in bench.items() if key not in ("run", "command")},
                runs=(text["run"],),
                commands=(text["command"],) if text["command"] else (),
            )
        )
    return Table("timing", "Timing", CAPTION, COLUMNS, tuple(rows))
