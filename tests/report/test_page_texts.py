"""Texts of the pages, and the words that stand for figures."""

from repro.report.html.environment import prose, symbols
from repro.report.paper import load_figures, paper_folder


def test_texts_are_written_with_their_symbols_and_without_foreign_markup():
    assert symbols("MAE on D_H <b> in m/s^2") == "MAE on D<sub>H</sub> &lt;b&gt; in m/s²"
    assert "<li>one <em>two</em></li>" in prose("- one *two*")
    assert "<script>" not in prose("<script>alert(1)</script>")


def test_every_figure_has_a_text_alternative_of_its_own():
    alternatives = {figure.name: figure.alt for figure in load_figures(paper_folder())}
    assert all(len(alt) > 30 for alt in alternatives.values())
    assert len(set(alternatives.values())) == len(alternatives)
