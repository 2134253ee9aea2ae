"""Streamed least squares against all rows at once."""

import numpy as np
import pytest

from repro.learning.optimisers.least_squares import solve, streamed_solve


def blocks(matrix, right, sizes):
    ends = np.cumsum(sizes)
    return zip(np.split(matrix, ends), np.split(right, ends), strict=True)


@pytest.mark.parametrize("sizes", [[], [3], [100, 1, 40], [60, 60]])
def test_blocks_of_any_size_give_the_solution_of_all_rows(sizes):
    generator = np.random.default_rng(0)
    matrix, right = generator.normal(size=(200, 7)) * 10.0 ** np.arange(-3, 4), generator.normal(size=200)
    expected, rank = solve(matrix, right, 1e-12)
    ours, our_rank = streamed_solve(blocks(matrix, right, sizes), 1e-12)
    np.testing.assert_allclose(ours, expected, rtol=1e-9)
    assert our_rank == rank == 7


def test_columns_that_depend_on_each_other_are_seen_across_blocks():
    generator = np.random.default_rng(1)
    matrix = generator.normal(size=(90, 4))
    matrix[:, 3] = matrix[:, 0] - 2 * matrix[:, 1]
    right = matrix @ [1.0, 2.0, 3.0, 0.0]
    solution, rank = streamed_solve(blocks(matrix, right, [30, 30]), 1e-10)
    assert rank == 3
    np.testing.assert_allclose(matrix @ solution, right, atol=1e-10)


def test_no_rows_are_an_error():
    with pytest.raises(ValueError, match="no rows"):
        streamed_solve([], 1e-12)
