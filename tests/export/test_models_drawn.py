import json

import numpy as np

from repro.export.architecture import FILE, architecture


def test_the_diagrams_show_the_models_as_they_are():
    """After a change of the models: python -m repro.export.architecture."""
    assert json.loads(FILE.read_text(encoding="utf-8")) == architecture()


def test_weights_add_up_and_the_matrices_have_their_structure():
    parts = architecture()
    plnn, port = parts["plnn"], parts["port"]
    assert plnn["weights"] == plnn["T"]["weights"] + plnn["V"]["weights"] + plnn["M"]["weights"]
    assert port["A"]["layers"][-1] == port["L below"]["layers"][-1] == 4 * 3 // 2
    assert np.array_equal(np.array(port["J"]), -np.array(port["J"]).T)
    assert np.array_equal(np.array(port["R"]), np.array(port["R"]).T)
    assert np.linalg.eigvalsh(port["R"]).min() > -1e-2
