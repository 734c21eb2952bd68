"""Detection of pocketed balls: the position of the fall, and the stored positions."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.model import POCKETS, Samples, Table
from ghostball.reference_adapters.stepping.pocketing import (
    Fall,
    Pocketing,
    instant_of,
    states_at_falls,
)

TABLE = Table.model_validate("wpa-9ft")
BOTTOM = POCKETS.index("bottom")
HOLE = next(hole for hole in TABLE.holes if hole.pocket == BOTTOM)
EDGE = HOLE.centre[1] + HOLE.radius


def pocketing(*places: tuple[float, float]) -> tuple[Pocketing, np.ndarray]:
    scene = scene_of(*(ball(place) for place in places), table=TABLE)
    return Pocketing(scene), scene.positions[:, :2]


def test_a_ball_falls_within_a_step_where_its_way_crosses_the_circle() -> None:
    rule, before = pocketing((1.27, 0.3), (0.5, 0.5))
    after = before + np.array([[0.0, -0.4], [0.1, 0.1]])
    ((fallen, pocket, part, place),) = rule.take(before, after)
    assert (fallen, pocket) == (0, BOTTOM)
    assert place == pytest.approx([1.27, EDGE], abs=1e-15)
    assert part == pytest.approx((0.3 - EDGE) / 0.4, rel=1e-14)
    assert rule.gone.tolist() == [True, False]
    assert rule.take(after, after) == []  # only once
    rule.keep(after)
    assert after.tolist() == [place.tolist(), [0.6, 0.6]]


@pytest.mark.parametrize(("inside", "falls"), [(1e-9, True), (-1e-9, False)])
def test_a_step_through_the_hole_counts_though_both_its_ends_are_outside(
    inside: float, falls: bool
) -> None:
    rule, before = pocketing((0.9, 0.2))
    y = EDGE - inside
    before[0] = 0.9, y
    found = rule.take(before, np.array([[1.6, y]]))
    assert bool(found) == falls
    if found:
        half = math.sqrt(HOLE.radius**2 - (HOLE.radius - inside) ** 2)
        assert found[0].place == pytest.approx([1.27 - half, y], abs=1e-10)


def test_a_ball_that_leaves_or_passes_does_not_fall() -> None:
    rule, before = pocketing((1.27, 0.04))
    assert rule.take(before, before + np.array([0.3, 0.0])) == []
    assert rule.take(before, before + np.array([0.0, 0.3])) == []


def test_one_that_was_pushed_into_the_hole_falls_at_once() -> None:
    rule, before = pocketing((1.27, 0.04))
    before[0, 1] = EDGE - 1e-4
    ((_, _, part, place),) = rule.take(before, before + np.array([0.0, 0.3]))
    assert part == 0.0
    assert place.tolist() == before[0].tolist()


def test_many_small_steps_find_what_one_finds() -> None:
    """A ball that has moved far enough since its last check must be checked again."""
    rng = np.random.default_rng(35)
    for _ in range(40):
        start = rng.uniform((0.4, 0.2), (2.1, 1.0))
        end = np.array([1.27, HOLE.centre[1]]) + rng.normal(size=2) * 0.12
        whole, before = pocketing(tuple(start))
        wanted = whole.take(before, end[np.newaxis])
        small, _ = pocketing(tuple(start))
        ways = start + np.linspace(0.0, 1.0, 301)[:, np.newaxis] * (end - start)
        found = [
            fall
            for one, other in pairwise(ways)
            for fall in small.take(one[np.newaxis], other[np.newaxis])
        ]
        assert [fall.pocket for fall in found] == [fall.pocket for fall in wanted]
        for fall, want in zip(found, wanted, strict=True):
            assert fall.place == pytest.approx(want.place, abs=1e-13)


def test_falls_of_a_step_are_in_order_of_time() -> None:
    rule, before = pocketing((1.27, 0.3), (1.25, 0.15))
    falls = rule.take(before, before - (0.0, 0.4))
    assert [fall.ball for fall in falls] == [1, 0]
    assert rule.here.tolist() == [False, False]


def test_a_table_without_pockets_asks_for_nothing() -> None:
    rule = Pocketing(scene_of(ball((0.5, 0.5)), table=Table(length=1.0, width=1.0)))
    assert not rule
    assert rule.here == slice(None)


def test_the_states_at_falls() -> None:
    before = np.array([[0.0, 0.0], [1.0, 0.0]])
    moving = Samples(
        np.array([[[0.4, 0.0, 0.03], [1.0, 0.8, 0.03]]]),
        np.array([[[4.0, 0.0, 0.0], [0.0, 8.0, 0.0]]]),
        np.ones((1, 2, 3)),
    )
    falls = [Fall(1, 0, 0.25, np.array([1.0, 0.2])), Fall(0, 0, 0.5, np.array([0.2, 0.0]))]
    found = list(states_at_falls(before, moving, falls))
    assert [fall.ball for fall, _ in found] == [1, 1, 0, 0]
    _, states = zip(*found, strict=True)
    assert [state.positions[0, :, 0].tolist() for state in states[::2]] == [[0.1, 1.0], [0.2, 1.0]]
    assert [state.positions[0, 1, 1] for state in states] == [0.2] * 4
    speeds = [np.abs(state.velocities[0]).max(axis=1).tolist() for state in states]
    assert speeds == [[4.0, 8.0], [4.0, 0.0], [4.0, 0.0], [0.0, 0.0]]
    assert states[1].angular_velocities[0].tolist() == [[1.0] * 3, [0.0] * 3]
    assert instant_of(falls[1], 2.0, 2.1) == pytest.approx(2.05, rel=1e-15)
    assert instant_of(falls[1]._replace(part=1.0), 0.3, 0.1 + 0.2 + 1e-17) <= 0.1 + 0.2
