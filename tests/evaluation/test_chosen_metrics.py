"""Metrics of evaluation/metrics, which are taken where they are chosen."""

import numpy as np
import pytest

from repro.evaluation.metrics import none, quantiles
from repro.models.kinds import blackbox
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.trivial import Trivial


def test_no_metric_is_no_number(data):
    assert [*none.Options().measure(Trivial(2), None, data.test, None, "test")] == []


def test_quantiles_of_a_model_that_predicts_zeros_are_those_of_the_data(data):
    part = data.test
    weights = np.zeros((part.members, 0))
    found = {m.name: m for m in quantiles.Options(shares=(0.5, 0.9)).measure(Trivial(2), weights, part, None, "test")}
    assert list(found) == ["quantile_tau[0.5]", "quantile_tau[0.9]", "quantile_qdd[0.5]", "quantile_qdd[0.9]"]
    for member in range(part.members):
        share = (np.abs(part.qdd[member]) <= found["quantile_qdd[0.9]"].values[member]).mean()
        assert share == pytest.approx(0.9, abs=1 / part.samples)
    assert found["quantile_tau[0.5]"].unit == "N, N m"


def test_a_model_that_predicts_accelerations_has_no_quantile_of_tau(data):
    model = BlackBox(2, blackbox.Options(hidden=(3,)))
    weights = model.initial([np.random.default_rng(i) for i in range(data.members)])
    names = [m.name for m in quantiles.Options().measure(model, weights, data.test, None, "test")]
    assert names == ["quantile_qdd[0.9]", "quantile_qdd[0.99]"]
