"""Tables are read whatever program wrote them: each kind from an invented recording of a few rows."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from repro.data.tables.read import read_table
from repro.data.tables.units import seconds
from repro.errors import UserError

ROWS = [(0.0, 1.25, -3.5, "up"), (0.02, 1.5, 2000.0, "up"), (0.04, -1e-3, 0.0, "down")]
HEADER = ("time", "angle", "force", "trial")


def text(separator: str = ",", decimal: str = ".", before: str = "", below: str = "", end: str = "") -> str:
    lines = [separator.join(HEADER) + below]
    lines += [separator.join(f"{cell}".replace(".", decimal) for cell in row) + end for row in ROWS]
    return before + "\n".join(lines) + "\n"


QUOTED = "\n".join(",".join(f'"{cell}"' for cell in row) for row in (HEADER, *ROWS))
KINDS = {
    "plain": text().encode(),
    "semicolon": text(";").encode(),
    "semicolon, decimal comma": text(";", ",").encode(),
    "tab": text("\t").encode(),
    "tab, decimal comma": text("\t", ",").encode(),
    "bar": text("|").encode(),
    "blanks": text("   ").encode(),
    "blanks after commas": text(", ").encode(),
    "comments": text(before="# rig 2, 50 Hz\n% by hand\n").encode(),
    "header in a comment": text(before="# rig 2\n# ").encode(),
    "comment further down": text().replace("0.02", "# pause\n0.02").encode(),
    "row of units": text(below="\ns,rad,N,").encode(),
    "spreadsheet": text(";", ",", before="sep=;\n").encode(),
    "commas at the ends of rows": text(end=",").encode(),
    "commas at the ends of all lines": text(below=",", end=",").encode(),
    "byte order mark, carriage returns": text().replace("\n", "\r\n").encode("utf-8-sig"),
    "utf-16": text().encode("utf-16"),
    "quoted": QUOTED.encode(),
    "compressed": gzip.compress(text().encode()),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["mine.csv", "MINE.TXT"])
def test_text_of_every_dialect(tmp_path: Path, kind: str, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(KINDS[kind])
    table = read_table(path)
    expected = np.array([row[:3] for row in ROWS])
    np.testing.assert_array_equal(table.numbers(table.names(HEADER[:3])), expected)
    assert table.frame["trial"].to_list() == [row[3] for row in ROWS]
    assert table.units.get("angle") == ("rad" if kind == "row of units" else None)


def test_names_with_units_commas_and_accents(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text('t [s],"F, cart",θ (rad),Größe\n0,1,2,3\n1,2,3,4\n', encoding="latin-1", errors="replace")
    assert read_table(path).numbers(["F, cart", "Größe"]).tolist() == [[1, 3], [2, 4]]


def test_a_name_that_stands_twice(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text("t,x,x\n0,1,2\n1,2,3\n")
    table = read_table(path)
    assert table.names(["t"]) == ["t"]
    with pytest.raises(UserError, match="'x' stands twice"):
        table.names(["x"])


def test_parquet_with_index_lists_and_nullable_numbers(tmp_path: Path) -> None:
    path = tmp_path / "mine.pq"
    frame = pd.DataFrame(
        {"state": [[0.5, 1.0], [0.25, 2.0]], "count": pd.array([3, None], dtype="Int64")},
        index=pd.Index([0.0, 0.1], name="time"),
    )
    frame.to_parquet(path)
    table = read_table(path)
    assert table.names(["state"]) == ["state[0]", "state[1]"]
    np.testing.assert_array_equal(table.numbers(["time", "state[1]"]), [[0.0, 1.0], [0.1, 2.0]])
    np.testing.assert_array_equal(table.numbers(["count"]), [[3.0], [np.nan]])
    pd.DataFrame({"state": [[0.5, 1.0], [0.25]]}).to_parquet(path)
    with pytest.raises(UserError, match="different lengths"):
        read_table(path)


STAMPS = pd.date_range("2024-02-03 04:05:06", periods=4, freq="20ms")
NANOSECONDS = STAMPS.as_unit("ns").asi8


@pytest.mark.parametrize(
    ("column", "unit", "said"),
    [
        (0.02 * np.arange(4), None, ""),
        (20 * np.arange(4), "ms", ""),
        (20 * np.arange(4), 1e-3, ""),
        (NANOSECONDS, None, "ns since 1970"),
        (NANOSECONDS // 1000, None, "us since 1970"),
        (NANOSECONDS // 10**6, None, "ms since 1970"),
        (STAMPS, None, "dates"),
        (STAMPS.tz_localize("Europe/Berlin"), None, "dates"),
        (STAMPS.strftime("%Y-%m-%d %H:%M:%S.%f"), None, "dates"),
        (STAMPS - STAMPS[0], None, ""),
    ],
)
def test_stamps_are_seconds(tmp_path: Path, column, unit, said: str) -> None:
    pd.DataFrame({"when": column}).to_parquet(tmp_path / "mine.parquet")
    time, notes = seconds(read_table(tmp_path / "mine.parquet"), "when", unit)
    np.testing.assert_allclose(time - time[0], 0.02 * np.arange(4), atol=1e-9)
    assert said in " ".join(notes)


def test_stamps_that_are_neither(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("when,x\nnoon,1\nlater,2\n")
    with pytest.raises(UserError, match="'noon', neither a number of seconds nor a date"):
        seconds(read_table(tmp_path / "mine.csv"), "when", None)
