"""The small drawings of the pages: where their marks stand."""

import math
import re

import pandas as pd
import pytest

from repro.claims.claims import Claim, Tolerance
from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import Verdict
from repro.report.drawing import FIGURES
from repro.report.html.described import SEEN, described
from repro.report.html.environment import prose, symbols
from repro.report.html.learning_curve import learning_curve
from repro.report.html.ratio_strip import WIDTH, ratio_strip
from repro.results.statistics import NOTHING, Estimate


def verdict(median: float, low: float = math.nan, high: float = math.nan, printed: float | None = 2.0) -> Verdict:
    texts = dict.fromkeys(("section", "quote", "about", "experiment", "metric", "unit"), "text")
    tolerance = Tolerance(factor=10.0, reason="a decade")
    claim = Claim(id="C1", kind="number", **texts, printed=2.0, selector={"basis": "t2"}, tolerance=tolerance)
    found = NOTHING if math.isnan(median) else Estimate(median, low, high, 5)
    claim = claim.model_copy(update={"printed": printed})
    return Verdict(claim, VerdictKind.MATCHED, "mae_tau", "N", found)


def test_the_printed_value_is_in_the_middle_and_decades_are_even():
    middle = WIDTH / 2
    assert f'cx="{middle:.1f}"' in ratio_strip(verdict(2.0))
    assert f'cx="{middle + WIDTH / 6:.1f}"' in ratio_strip(verdict(20.0))
    assert f'x="{middle - WIDTH / 6:.1f}" width="{WIDTH / 3:.1f}"' in ratio_strip(verdict(2.0))


def test_what_is_beyond_the_scale_is_an_arrow_at_its_end():
    assert f'<polygon points="{WIDTH},' in ratio_strip(verdict(2e9))
    assert '<polygon points="0,' in ratio_strip(verdict(2e-9))


def test_the_strip_is_said_in_words_and_absent_without_two_numbers():
    assert 'aria-label="ours is 3 times the printed value"' in ratio_strip(verdict(6.0, 5.0, 7.0))
    assert ratio_strip(verdict(6.0, printed=None)) is None
    assert ratio_strip(verdict(math.nan)) is None


@pytest.mark.parametrize("broken", [math.nan, math.inf, 0.0])
def test_a_learning_curve_falls_from_top_left_to_bottom_right(broken):
    steps = range(0, 1001, 10)
    rows = [("r", member, step, "loss", 10.0 ** (2 - step / 250) * (1 + member)) for member in (0, 1) for step in steps]
    rows.append(("r", 2, 0, "loss", broken))
    drawn = learning_curve(pd.DataFrame(rows, columns=["run", "member", "step", "name", "value"]))
    assert "the median loss goes from 150 to 0.015 in 1000 steps" in drawn
    lines = re.findall(r'<polyline class="(\w+)" points="([^"]+)"', drawn)
    assert [kind for kind, _ in lines] == ["member", "member", "middle"]
    points = [tuple(map(int, point.split(","))) for point in lines[-1][1].split()]
    assert points[0][0] == 0 and points[-1][0] == 360
    assert points == sorted(points) and len(points) <= 60


def test_without_steps_there_is_no_curve():
    once = pd.DataFrame([("r", 0, 0, "loss", 1.0)], columns=["run", "member", "step", "name", "value"])
    assert learning_curve(once) is None
    assert learning_curve(None) is None


def test_texts_are_written_with_their_symbols_and_without_foreign_markup():
    assert symbols("MAE on D_H <b> in m/s^2") == "MAE on D<sub>H</sub> &lt;b&gt; in m/s²"
    assert "<li>one <em>two</em></li>" in prose("- one *two*")
    assert "<script>" not in prose("<script>alert(1)</script>")


def test_every_figure_is_described_in_words():
    assert {figure.name for figure in FIGURES} == set(SEEN)
    assert all(described(figure) != figure.title for figure in FIGURES)
