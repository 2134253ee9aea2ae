"""What the drawings of the models show is what the models consist of."""

import importlib.util
import json

import numpy as np
import pytest

from repro.report.paper import paper_folder

SCRIPT = paper_folder() / "describe_models.py"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("describe_models", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_diagrams_show_the_models_as_they_are(script):
    """After a change of the models: python paper/describe_models.py."""
    assert json.loads(script.FILE.read_text(encoding="utf-8")) == script.architecture()


def test_weights_add_up_and_the_matrices_have_their_structure(script):
    parts = script.architecture()
    plnn, port = parts["plnn"], parts["port"]
    assert plnn["weights"] == plnn["T"]["weights"] + plnn["V"]["weights"] + plnn["M"]["weights"]
    assert port["A"]["layers"][-1] == port["L below"]["layers"][-1] == 4 * 3 // 2
    assert np.array_equal(np.array(port["J"]), -np.array(port["J"]).T)
    assert np.array_equal(np.array(port["R"]), np.array(port["R"]).T)
    assert np.linalg.eigvalsh(port["R"]).min() > 0  # rounding to three decimals moves it by less than 0.002
