"""The table and the terminal view of what each assumption does to the verdicts."""

import pytest
from report_drift import table_drift
from synthetic_sensitivity import CLAIMS, sensitivity_runs

from repro.claims.assumption_effects import assumption_effects
from repro.claims.assumptions import Assumption
from repro.report.tables.sensitivity import sensitivity_table
from repro.report.terminal import show_sensitivity

TEXTS = dict.fromkeys(("where", "quote", "problem", "choice", "config", "evidence"), "text")
LEDGER = [
    Assumption(id="data_regime", **TEXTS, sensitivity=[{"claims": ["C4a", "C14a"], "instead": ["data=long"]}]),
    Assumption(id="momentum", **TEXTS, sensitivity="an erratum"),
]


@pytest.fixture
def effects(store):
    return assumption_effects(sensitivity_runs(store), CLAIMS)


def test_the_table_has_every_assumption_and_its_drift_is_seen(effects, tmp_path):
    table = sensitivity_table(LEDGER, effects)
    assert [row.cells[0] for row in table.rows] == ["data_regime", "data_regime", "momentum"]
    assert table.rows[0].cells[7:] == ("consistent → outside", "moved")
    assert "an erratum" in table.rows[2].cells
    table.save(tmp_path)
    committed, key = tmp_path / "sensitivity.csv", ("assumption", "alternative", "claim")
    assert table_drift(committed, table, key) == []
    text = committed.read_text()
    committed.write_text(text.replace(",0.3,0.3,", ",0.3,0.3000000000001,", 1))
    assert table_drift(committed, table, key) == []
    committed.write_text(text.replace(",outside,", ",consistent,", 1))
    assert table_drift(committed, table, key) == [
        "sensitivity.csv holds another instead_leaning of data_regime data=long C4a than outside"
    ]
    committed.write_text(text.splitlines()[0])
    assert len(table_drift(committed, table, key)) == 3


def test_the_terminal_marks_what_moves_and_fits_its_width(effects, capsys):
    from rich.console import Console

    for width in (80, 140):
        show_sensitivity(effects, Console(width=width))
        text = capsys.readouterr().out
        assert all(len(line) <= width for line in text.splitlines())
        assert "consistent → outside" in text
        assert "2 of 2 assumptions move an answer" in text
