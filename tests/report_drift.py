"""Whether committed pages and tables are what the committed results give, to the digits that machines keep."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from repro.claims.assumption_effects import assumption_effects
from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.verdicts import judge_all
from repro.report import readme
from repro.report.tables.sensitivity import sensitivity_table
from repro.report.tables.table import Table
from repro.report.tables.verdicts import verdict_table
from repro.results.results import Results

# The last digits of a quantile differ between versions of the libraries.
TOLERANCE = 1e-9


def drift(root: Path) -> list[str]:
    """List where README.md, docs and the verdicts of paper/results differ from what its results give; [] when nowhere.

    `root` is the checkout: it holds README.md, docs, paper/claims.yaml, paper/assumptions.yaml and paper/results.
    """
    paper = root / "paper"
    results, claims = Results.load(paper / "results"), load_claims(paper / "claims.yaml")
    verdicts = judge_all(claims, results)
    differences = []
    for name, block in readme.blocks(results, verdicts).items():
        page = readme.page_of(root, name)
        if readme.parts(page, name)[1].strip() != block.strip():
            shown = page.relative_to(root).as_posix()
            differences.append(f"{shown} shows another table of {name} than paper/results gives")
    differences += table_drift(paper / "results" / "claims.csv", verdict_table(verdicts), ("id",))
    if results.sensitivity is not None:
        ledger = load_assumptions(paper / "assumptions.yaml")
        table = sensitivity_table(ledger, assumption_effects(results.sensitivity, claims))
        key = ("assumption", "alternative", "claim")
        differences += table_drift(paper / "results" / "sensitivity.csv", table, key)
    return differences


def table_drift(path: Path, table: Table, key: Sequence[str]) -> list[str]:
    """Say in which rows, named by their columns `key`, a committed CSV file differs from a table computed anew."""
    if not path.is_file():
        return [f"{path.name} is not there"]
    committed = _rows(path.read_text(encoding="utf-8"), key)
    now = _rows(table.csv(), key)
    differences = []
    for name in dict.fromkeys([*now, *committed]):
        if name not in now or name not in committed:
            differences.append(f"{path.name} {'lacks' if name in now else 'holds'} {name}")
            continue
        differing = [c for c in now[name] if not _same(committed[name].get(c) or "", now[name][c])]
        differences += [f"{path.name} holds another {c} of {name} than {now[name][c] or 'none'}" for c in differing]
    return differences


def _rows(text: str, key: Sequence[str]) -> dict[str, Mapping[str, str]]:
    return {" ".join(row[c] for c in key if row[c]): row for row in csv.DictReader(io.StringIO(text))}


def _same(committed: str, now: str) -> bool:
    try:
        first, second = float(committed), float(now)
    except ValueError:
        return committed == now
    return (
        first == second or math.isclose(first, second, rel_tol=TOLERANCE) or (math.isnan(first) and math.isnan(second))
    )
