"""A bench is a stored stage with the columns that the report reads, and is not repeated."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from repro.bench import peers, stored_bench, suite
from repro.bench.pairing import PairedComparison, Pairs, Rounds
from repro.bench.scale import SCALES
from repro.bench.stored_bench import FILE, MeasuredRows, run, stage
from repro.commands import bench as command
from repro.commands.arguments import parsed
from repro.results.gather import gather
from repro.results.stored import read_stored
from repro.results.table_schema import TABLES
from repro.tracking.store import Store

# torch.func loads its rules for forward mode with a function that torch itself deprecates
pytestmark = [
    pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning"),
    pytest.mark.usefixtures("unoptimised"),
]


@pytest.fixture
def measured(monkeypatch):
    """Comparisons with known times; the list grows with each measurement."""
    done = []

    def measure(name):
        done.append(name)
        return Pairs(np.array([1e-3, 1e-3, 2e-3]), np.array([2e-3, 3e-3, 8e-3]))

    def comparisons(scale):
        return [
            PairedComparison(name, "inverse", "forward", "1x10", 1, "{pairs} pairs", lambda name=name: measure(name))
            for name in ("forward_vs_inverse", "engine")
        ]

    monkeypatch.setattr(suite, "comparisons", comparisons)
    return done


def test_the_stored_table_has_the_columns_of_the_report(tmp_path, measured):
    rows = pd.read_parquet(tmp_path / "bench" / run(tmp_path, "smoke") / FILE)
    assert list(rows) == [column for column in TABLES["bench"] if column not in ("run", "command")]
    for column in rows:
        checks = {str: pd.api.types.is_string_dtype, int: pd.api.types.is_integer_dtype}
        assert checks.get(TABLES["bench"][column], pd.api.types.is_float_dtype)(rows[column])
    first = rows.iloc[0]
    assert (first.ratio_q25, first.ratio_median, first.ratio_q75) == (2.0, 3.0, 4.0)
    assert (first.ours_ms, first.other_ms, first.threads, first.protocol) == (1.0, 3.0, 1, "3 pairs")


def test_a_finished_bench_is_not_repeated(tmp_path, measured):
    assert run(tmp_path, "smoke") == run(tmp_path, "smoke")
    assert measured == ["forward_vs_inverse", "engine"]


def test_an_interrupted_bench_goes_on_where_it_was(tmp_path, measured, monkeypatch):
    def killed(name):
        raise KeyboardInterrupt

    whole = suite.comparisons("smoke")
    first, second = whole
    monkeypatch.setattr(suite, "comparisons", lambda scale: [first, replace(second, measure=lambda: killed("engine"))])
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, "smoke")
    monkeypatch.setattr(suite, "comparisons", lambda scale: whole)
    rows = pd.read_parquet(tmp_path / "bench" / run(tmp_path, "smoke") / FILE)
    assert measured == ["forward_vs_inverse", "engine"]
    assert list(rows["name"]) == measured and set(rows["ratio_median"]) == {3.0}


def test_a_stored_row_is_the_measured_one(tmp_path, measured):
    """Infinite times and undefined memory too."""
    (comparison, _) = suite.comparisons("smoke")
    never = replace(comparison, measure=lambda: Pairs(np.array([1.0]), np.array([np.inf])), metric="MAE_qdd", goal=0.1)
    for each in (comparison, never):
        first, again = (MeasuredRows(tmp_path).row(each) for _ in range(2))
        pd.testing.assert_series_equal(pd.Series(first), pd.Series(again))
    assert len(measured) == 1
    assert (again["other_ms"], again["ratio_median"], again["ours_reached"], again["other_reached"]) == (
        (np.inf, np.inf, 1, 0)
    )


def test_what_is_left_out_is_said(tmp_path, measured, monkeypatch, capsys):
    monkeypatch.setattr(peers, "_version", lambda package: None)
    run(tmp_path, "smoke")
    assert "left out: jax, phlearn, pysindy, do-mpc" in capsys.readouterr().err


def test_another_machine_or_scale_is_another_bench(monkeypatch):
    here = stage("smoke").id
    assert stage("quick").id != here
    monkeypatch.setattr(stored_bench, "describe_machine", lambda: {"processor": "another"})
    assert stage("smoke").id != here


def test_the_bench_depends_on_what_it_times_and_not_on_its_own_table():
    code = set(stage("smoke").identity.code)
    timed = {
        "learning.native",
        "learning.kernels.network_kernel",
        "models.network",
        "bench.naive",
        "mechanics.systems.sip",
    }
    assert {f"repro.{name}" for name in timed} <= code
    assert "repro.commands.bench" not in code


def test_the_report_finds_it_under_its_experiment(tmp_path, measured):
    id = run(tmp_path, "smoke")
    listed = json.loads((tmp_path / "experiments" / "smoke" / "timing.json").read_text())
    assert [(job["run"], job["command"]) for job in listed["jobs"]] == [(id, "repro bench --scale smoke")]
    results = gather(read_stored(tmp_path, "smoke"))
    assert list(results.bench["name"]) == ["forward_vs_inverse", "engine"]
    assert set(results.bench["command"]) == {"repro bench --scale smoke"}


def test_every_comparison_of_the_smallest_scale_gives_a_row(tmp_path, monkeypatch):
    once = Rounds(least=1, most=1, limit_s=0.0, shortest_s=0.0)
    monkeypatch.setitem(suite.SCALES, "smoke", replace(SCALES["smoke"], rounds=once))
    record = Store(tmp_path).find(run(tmp_path, "smoke"))
    rows = pd.read_parquet(record.path(FILE))
    assert len(rows) == record.summary["comparisons"] == len(suite.comparisons("smoke"))
    assert (rows["ours_ms"] > 0).all()
    to_accuracy = rows["name"].str.endswith("_accuracy") | (rows["name"] == "path")  # some never arrive
    assert np.isfinite(rows["other_ms"][~to_accuracy]).all()


@pytest.mark.parametrize("scale", SCALES)
def test_each_scale_answers_every_part_of_the_claim(scale):
    names = {comparison.name for comparison in suite.comparisons(scale)}
    ways = {f"{rival}_{way}" for rival in ("lnn", "delan", "linn") for way in ("naive", "best", "accuracy")}
    others = {"delan_automatic", "engine", "coordinates", "members", "samples", "path", "structured_accuracy"}
    others |= {"delan_analytic_accuracy", "delan_automatic_accuracy"}
    others |= {"optimisers"} if scale != "smoke" else set()
    assert names - {"peers", "control"} == ways | others


def test_the_command_shows_the_ratios(tmp_path, measured, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))
    assert command.main(parsed("bench", ["--scale", "smoke"])) == 0
    shown = capsys.readouterr().out
    assert "forward_vs_inverse" in shown
    assert "3 (2 to 4)" in shown


def test_the_command_names_what_failed(tmp_path, monkeypatch, capsys):
    def broken(scale):
        raise ValueError("no such net")

    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))
    monkeypatch.setattr(suite, "comparisons", broken)
    assert command.main(parsed("bench", ["--scale", "smoke"])) == 1
    assert "no such net" in capsys.readouterr().err
