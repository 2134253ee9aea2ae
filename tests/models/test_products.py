"""Products of named factors, and squares told from their expansion."""

import numpy as np
import pytest

from repro.models.products import pairwise, square_root

WORDS = {"xd": 2.0, "thetad cos(theta)": 3.0, "thetad": 5.0}


def test_each_pair_comes_once():
    products = pairwise(WORDS)
    assert list(products.values()) == [4.0, 6.0, 10.0, 9.0, 15.0, 25.0]
    assert list(products)[:4] == ["xd^2", "xd * thetad cos(theta)", "xd * thetad", "(thetad cos(theta))^2"]


@pytest.mark.parametrize("root", [{"xd": 1.0, "thetad": 0.25}, {"xd": 0.5, "thetad cos(theta)": -2.0, "thetad": 0.1}])
def test_a_square_is_recognised(root):
    words = list(WORDS)
    pairs = [(a, b) for i, a in enumerate(words) for b in words[i:]]
    doubled = [(1 if a == b else 2) * root.get(a, 0.0) * root.get(b, 0.0) for a, b in pairs]
    expanded = dict(zip(pairwise(WORDS), doubled, strict=True))
    found = square_root(list(expanded), np.array([*expanded.values()]))
    sign = np.sign(max(root.values(), key=abs))
    assert found == pytest.approx({word: sign * value for word, value in root.items()})


@pytest.mark.parametrize(
    "coefficients", [[1, 0, 0, 1, 0, 0], [1, 0, 0, -1, 0, 0], [0, 1, 0, 0, 0, 0], [-1, 0, 0, 0, 0, 0]]
)
def test_what_is_no_square_is_none(coefficients):
    assert square_root(list(pairwise(WORDS)), np.array(coefficients, dtype=float)) is None


def test_terms_that_are_no_products_are_no_square():
    assert square_root(["xd^2", "thetad"], np.array([1.0, 1.0])) is None
