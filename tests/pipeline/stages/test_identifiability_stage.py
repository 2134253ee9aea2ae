"""What is written of the training data of a linear model."""

import pandas as pd
import pytest

from repro.learning.objectives import forward, inverse
from repro.learning.phases import TrainingData, phases_of
from repro.models.bases import t1, t2
from repro.models.kinds import blackbox
from repro.models.kinds.blackbox import BlackBox
from repro.models.lagrangian import Lagrangian
from repro.pipeline.stages.examine import FILE, applies, examine, keep, metrics, shortened


@pytest.fixture
def examined(recipe, data, free, system):
    model = Lagrangian(t1, 2)
    return examine(model, phases_of(model, *recipe("pretrain"), TrainingData([data], free, system, [3, 8])))


def test_each_phase_and_member_is_examined(examined):
    assert {name: [one.rank for one in members] for name, members in examined.items()} == {"D_H": [4, 4], "D": [4, 4]}


def test_the_metrics_have_a_value_a_member(examined):
    found = {metric.name: metric for metric in metrics(examined["D"])}
    assert {metric.split for metric in found.values()} == {"train"}
    assert found["rank"].values.tolist() == [4, 4] and found["null_directions"].values.tolist() == [0, 0]
    assert all(found["condition_raw"].values > found["condition_scaled"].values)


def test_a_row_a_direction_is_kept(tmp_path, examined):
    keep(tmp_path, examined, [3, 8])
    table = pd.read_parquet(tmp_path / FILE)
    assert table.columns.tolist() == ["member", "phase", "order", "value", "direction"]
    assert len(table) == 2 * 2 * 4 and set(table["member"]) == {3, 8} and set(table["direction"]) == {""}
    assert (table[table["order"] == 0]["value"] == 1).all()


def test_unseen_directions_are_kept_in_words(tmp_path, recipe, data, free, system):
    from repro.models.bases import fxf

    model = Lagrangian(fxf, 2)
    found = examine(model, phases_of(model, *recipe("pretrain_only"), TrainingData([data], free, system, [3, 8])))
    keep(tmp_path, found, [3, 8])
    table = pd.read_parquet(tmp_path / FILE)
    words = table[(table["member"] == 3) & (table["direction"] != "")]
    assert set(words["direction"]) == {
        "(thetad sin(theta))^2 + (thetad cos(theta))^2 - thetad^2",
        "(xd + 0.125 thetad cos(theta))^2",
    }
    assert words["value"].max() < 1e-8


def test_it_is_for_linear_regressions(data):
    assert applies(Lagrangian(t1, 2), inverse.Options()) and not applies(Lagrangian(t1, 2), forward.Options())
    assert not applies(Lagrangian(t2, 2, hidden=(3,)), inverse.Options())
    assert not applies(BlackBox(2, blackbox.Options()), forward.Options())
    assert shortened(data).n_train == data.n_train
