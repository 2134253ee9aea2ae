"""DeLaN with automatic derivatives is the triangular model, whose derivatives are written out."""

import numpy as np
import pytest
import torch

from repro.bench.naive import automatic_step
from repro.bench.training_case import (
    TrainingCase,
    network,
    pendulum_case,
    random_case,
    started,
    torch_step,
    triangular,
)
from repro.models.bases import t2

# torch.func loads its rules for forward mode with a function that torch itself deprecates
pytestmark = pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning")


@pytest.mark.parametrize(("n_q", "hidden"), [(2, (5,)), (3, (7, 5))])
def test_both_forms_have_one_loss_and_gradient(n_q, hidden):
    data = random_case(n_q, (4,), 20).dataset
    case = started(triangular(hidden)(data), data)
    turned = case.parameters.numpy() + 0.2 * np.random.default_rng(3).normal(size=tuple(case.parameters.shape))
    case = TrainingCase(case.model, torch.from_numpy(turned), case.dataset)
    for automatic, analytic in zip(automatic_step(case)(), torch_step(case, "inverse")(), strict=True):
        np.testing.assert_allclose(automatic, analytic, rtol=1e-9, atol=1e-12 * np.abs(analytic).max())


def test_each_member_has_its_own_samples():
    case = pendulum_case(triangular((5,)), 3, 30)
    losses, gradients = automatic_step(case)()
    expected, slopes = torch_step(case, "inverse")()
    np.testing.assert_allclose(losses, expected, rtol=1e-9)
    np.testing.assert_allclose(gradients, slopes, rtol=1e-7, atol=1e-9)
    assert len(set(losses)) == 3


def test_another_model_has_no_such_form():
    with pytest.raises(TypeError, match="triangular"):
        automatic_step(pendulum_case(network(t2, (4,)), 1, 20))
