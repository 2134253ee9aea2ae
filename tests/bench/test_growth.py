"""What the scaling comparisons compute."""

import numpy as np
import pytest
from optional import needs_compiler

from repro.bench import engines
from repro.bench.engines import streamed
from repro.bench.training_case import native_step, random_case, torch_step

pytestmark = pytest.mark.usefixtures("unoptimised")

TRUE_T1 = [0.4, 0.025, 0.1, 0.98]


def test_streamed_least_squares_find_the_true_coefficients_across_blocks(monkeypatch):
    monkeypatch.setattr(engines, "BLOCK", 300)
    np.testing.assert_allclose(streamed(1_000), TRUE_T1, rtol=1e-9)


@needs_compiler
@pytest.mark.parametrize("equation", ["inverse", "forward"])
@pytest.mark.parametrize("n_q", [1, 3, 8])
def test_engines_agree_for_any_number_of_coordinates(n_q, equation):
    case = random_case(n_q, (9, 5), 60)
    for compiled, torch in zip(native_step(case, equation)(), torch_step(case, equation)(), strict=True):
        np.testing.assert_allclose(compiled, torch, rtol=0, atol=1e-9 * np.abs(torch).max())
