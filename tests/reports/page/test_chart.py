"""Charts show the given curves, with ticks at the right positions."""

import re

import numpy as np

from ghostball.reports.page.chart import (
    BOTTOM,
    HEIGHT,
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    Series,
    draw,
    linear_axis,
    log_axis,
    thinned,
)


def points_of(svg):
    path = re.search(r'class="curve[^>]* d="([^"]*)"', svg)[1]
    return [
        [tuple(map(float, pair.split())) for pair in piece.split("L")]
        for piece in path.split("M")[1:]
    ]


def test_a_thinned_curve_stays_near():
    x = np.linspace(0.0, 400.0, 3000)
    curve = np.column_stack([x, 100.0 * np.sin(x / 30.0)])
    kept = thinned(curve, 0.4)
    assert len(kept) < 300
    assert np.array_equal(kept[[0, -1]], curve[[0, -1]])
    assert np.max(np.abs(np.interp(x, kept[:, 0], kept[:, 1]) - curve[:, 1])) < 1.5


def test_corners_of_the_axes_are_corners_of_the_box():
    one = Series("a", "red", np.array([0.0, 2.0]), np.array([0.0, 8.0]))
    svg = draw("t", [one], linear_axis("x", 2.0), linear_axis("y", 8.0))
    assert points_of(svg) == [[(LEFT, HEIGHT - BOTTOM), (WIDTH - RIGHT, TOP)]]


def test_nan_leaves_a_gap_and_infinity_is_at_the_edge():
    y = np.array([0.0, 1.0, np.nan, 3.0, np.inf, 1.0, 0.0])
    one = Series("a", "red", np.arange(7.0), y)
    pieces = points_of(draw("t", [one], linear_axis("x", 6.0), linear_axis("y", 4.0)))
    assert [len(piece) for piece in pieces] == [2, 4]
    assert pieces[1][1][1] == TOP


def test_what_lies_outside_is_drawn_at_the_edge():
    one = Series("a", "red", np.array([0.0, 1.0]), np.array([0.0, 1e300]))
    svg = draw("t", [one], linear_axis("x", 1.0), linear_axis("y", 1.0))
    assert points_of(svg)[0][1][1] == TOP
    low = Series("a", "red", np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    svg = draw("t", [low], linear_axis("x", 1.0), log_axis("y", 1e-6, 1.0))
    assert points_of(svg)[0][0][1] == HEIGHT - BOTTOM


def test_logarithmic_ticks_are_lengths():
    axis = log_axis("x", 1e-17, 1e3, "m")
    assert len(axis.ticks) <= 7
    assert dict(log_axis("x", 1e-5, 1.0, "m").ticks)[1e-3] == "1 mm"


def test_text_is_inert():
    one = Series("<img>", "red", np.arange(2.0), np.arange(2.0), marker="●", titles=["<b>", "&"])
    svg = draw('"><script>', [one], linear_axis("<x>", 1.0), linear_axis("y", 1.0), [(0.5, "<i>")])
    assert not re.search(r"<(script|img|b|i|x)>", svg)
