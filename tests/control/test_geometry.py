"""Distances of links to a disc: against brute force, and where they are known."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from repro.control.geometry import Disc, distances_squared
from repro.mechanics.shapes import Block, Circle, Segment, Spring
from repro.mechanics.system import load


def test_the_distance_is_that_of_the_nearest_point_of_the_segment():
    generator = np.random.default_rng(0)
    along = np.linspace(0, 1, 20001)[:, None]
    for _ in range(20):
        start, end, centre = generator.normal(size=(3, 2))
        nearest = np.linalg.norm(start + along * (end - start) - centre, axis=1).min()
        (squared,) = distances_squared([Segment(start, end)], centre, np)
        assert np.sqrt(squared) == pytest.approx(nearest, abs=1e-7)


def test_numpy_and_casadi_agree():
    points = np.random.default_rng(1).normal(size=(4, 2))
    shapes = [Segment(*points[:2]), Circle(points[2], 0.1, solid=True), Block(points[3], (0.2, 0.1), 0.5, solid=True)]
    expected = distances_squared(shapes, (0.2, 0.6), np)
    symbols = [[ca.SX(float(c)) for c in point] for point in points]
    same = [Segment(*symbols[:2]), replace(shapes[1], centre=symbols[2]), replace(shapes[2], centre=symbols[3])]
    symbolic = distances_squared(same, (0.2, 0.6), ca)
    np.testing.assert_allclose([float(value) for value in symbolic], expected, atol=1e-15)


@pytest.mark.parametrize(
    ("q", "expected"),
    [([0.0, np.pi], 0.3), ([0.0, 0.0], -0.2), ([0.3, 0.0], 0.0162), ([2.0, np.pi / 2], np.hypot(2.0, 0.6) - 0.3)],
    ids=["hanging below", "upright inside", "upright beside", "level far away"],
)
def test_clearances_of_the_single_pendulum(q, expected):
    assert Disc((0.0, 0.6), 0.3).clearance(load("sip"), np.array(q)) == pytest.approx(expected, abs=1e-4)


def test_every_link_of_the_double_pendulum_counts():
    """The tip is far away on the other side; the second link passes through the disc."""
    system = load("dip")
    q = np.array([0.3, 0.0, -np.pi / 2])
    points = system.body_points(list(q), np)
    assert np.linalg.norm(np.array(points[2]) - (0.0, 0.55)) > 0.2
    assert Disc((0.0, 0.55), 0.1).clearance(system, q) == pytest.approx(-0.05)
    assert Disc((0.0, 0.55), 0.1).clearance(system, np.stack([q, [9, *q[1:]]])).shape == (2,)


def test_solid_blocks_and_circles_are_met_at_their_sides():
    block = Block([0.0, 0.0], (2.0, 1.0), np.pi / 2, solid=True)  # turned: 1 across, 2 up
    (beside,) = distances_squared([block], (3.0, 0.5), np)
    (corner,) = distances_squared([block], (4.0, 6.0), np)
    assert (np.sqrt(beside), np.sqrt(corner)) == pytest.approx((2.0, 5.0))
    assert distances_squared([Circle([3.0, 4.0], 1.0, solid=True)], (0.0, 0.0), np) == pytest.approx([16.0])
    assert distances_squared([Circle([3.0, 4.0], 1.0), Spring([0, 0], [1, 0])], (0.0, 0.0), np) == []
