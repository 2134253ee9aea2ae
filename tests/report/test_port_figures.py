"""Figures of passivity, composition and chains show what is stored, and nothing where nothing is."""

import numpy as np

from repro.report.paper import load_figures, paper_folder
from repro.results.selectors import settings

DRAW = {figure.name: figure.draw for figure in load_figures(paper_folder())}
OF_THE_MODELS = {"framework", "plnn", "port_matrices"}  # drawn whatever was run


def test_nothing_is_drawn_where_nothing_is_stored(store):
    store.run("mine", {"mae_tau": [0.2, 0.3]})
    stored = store.gathered()
    assert {name for name, draw in DRAW.items() if draw(stored) is not None} == OF_THE_MODELS


def test_a_margin_is_the_worst_of_all_members_at_each_step(results):
    (panel,) = DRAW["passivity_margin"](results).axes
    lines = {line.get_label(): line.get_ydata() for line in panel.lines}
    np.testing.assert_allclose(next(y for label, y in lines.items() if "port" in label), [-1e-4] * 6, rtol=1e-6)
    np.testing.assert_allclose(next(y for label, y in lines.items() if "black" in label), [1e-4] * 6, rtol=1e-6)


def test_energies_of_all_models_are_drawn_beside_the_plant_and_its_error(results):
    energy, error = (axes for axes in DRAW["energy_over_time"](results).axes if axes.lines)
    plant, *models = energy.lines
    assert plant.get_label() == "plant" and len(models) == len(error.lines) == 2
    np.testing.assert_allclose(plant.get_ydata(), 1 + 0.1 * np.arange(5))
    for model, gap in zip(models, error.lines, strict=True):
        np.testing.assert_allclose(np.nan_to_num(gap.get_ydata()), np.abs(model.get_ydata() - plant.get_ydata()))
    assert any("black box" in line.get_label() for line in models)


def test_medians_against_the_number_of_samples(results):
    panel = DRAW["composition"](results).axes[0]
    lines = {line.get_label(): line for line in panel.lines if not line.get_label().startswith("_")}
    assert set(lines) == {"all of L from scratch", "trained part + one mass"}
    for line in lines.values():
        np.testing.assert_array_equal(line.get_xdata(), [10, 30, 1000])
    scratch, mass = (lines[name].get_ydata() for name in ("all of L from scratch", "trained part + one mass"))
    assert (mass < scratch).all()


def test_chains_against_their_length(results):
    """Medians of five members, in the panels of the error and of the processor time."""
    (chain,) = settings(results, "chains", {"system": "link"})
    for panel, metric in zip(DRAW["chains"](results).axes, ("chain_error", "chain_seconds"), strict=True):
        (line,) = panel.lines
        np.testing.assert_array_equal(line.get_xdata(), [2, 1000])
        medians = [np.median(chain.values(f"{metric}_{links}")) for links in (2, 1000)]
        np.testing.assert_allclose(line.get_ydata(), medians)
