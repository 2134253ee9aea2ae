"""A chain's recording shows the masses where the simulation put them."""

import numpy as np
import pytest

from repro.evaluation.chains import random_start
from repro.mechanics.system import load
from repro.models.bases import spring
from repro.models.damped import Damped
from repro.models.lagrangian import Lagrangian
from repro.models.ports import ChainLink
from repro.pipeline.stages.record_chain import record
from repro.recording.writer import read_recording

LINK = load("link", damping=[0.3])
MODEL = Damped(Lagrangian(spring, 1), "diagonal")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chain")
    weights = np.array([0.25, 10.0, 10.0, 0.3])
    both = ChainLink.true(LINK), ChainLink.learned(MODEL, weights)
    summary = record(folder, ("run-1", "a title", {"key": 1}), both, 3, 4)
    assert summary == {"member": 3, "links": 4}
    return folder


def test_energies_of_plant_and_model_fall_together(folder):
    track = read_recording(folder / "recording.rrd")["energy/H"]
    assert track.values.shape == (101, 2)
    np.testing.assert_allclose(track.values[:, 0], track.values[:, 1], rtol=1e-9)
    assert (np.diff(track.values[:, 0]) < 0).all()
    np.testing.assert_allclose(track.at[[0, -1]], [0, 10])


def test_masses_start_where_the_extensions_put_them(folder):
    from rerun.chunk import RrdReader

    chunks = RrdReader(folder / "recording.rrd").stream().to_chunks()
    batches = [c.to_record_batch() for c in chunks if c.entity_path == "/scene/plant/disc1"]
    (moved,) = (b for b in batches if b.num_rows == 101)
    first = np.array(moved["Points2D:positions"][0].as_py())
    np.testing.assert_allclose(first[:, 0], np.arange(1, 5) + np.cumsum(random_start(4)[:4]), rtol=1e-6)


def test_a_chain_has_the_properties_of_every_run(folder):
    from rerun.chunk import RrdReader

    chunks = RrdReader(folder / "recording.rrd").stream().to_chunks()
    names = [name for c in chunks if c.entity_path == "/__properties/run" for name in c.to_record_batch().schema.names]
    assert "title" in names


def test_the_card_is_written_as_properties(folder):
    from rerun.chunk import RrdReader

    chunks = RrdReader(folder / "recording.rrd").stream().to_chunks()
    names = {n for c in chunks if "propert" in c.entity_path for n in c.to_record_batch().schema.names}
    assert any("title" in name for name in names) and any("key" in name for name in names)
