"""Where logs part: each ball's own order counts, nothing else."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ghostball.engine import EVENT_DTYPE, EventKind
from ghostball.validation.grading.collisions import (
    Collision,
    collisions_from,
    collisions_in,
    compare_logs,
)

BALLS = EventKind.BALL_BALL
CUSHION = EventKind.BALL_CUSHION


def hits(*rows):
    return [Collision(BALLS, a, b, t) for t, a, b in rows]


TRUE = hits((1.0, 0, 1), (1.5, 2, 3), (2.0, 1, 2), (3.0, 0, 3))


def test_a_log_agrees_with_itself_and_with_late_times():
    late = hits((1.1, 0, 1), (1.6, 2, 3), (2.2, 1, 2), (3.4, 0, 3))
    for other in (TRUE, late):
        found = compare_logs(TRUE, other)
        assert found.parting is None
        assert [a for a, _ in found.pairs] == TRUE
        assert found.before == found.pairs


def test_collisions_without_a_ball_in_common_may_swap():
    assert (
        compare_logs(TRUE, hits((1.0, 2, 3), (1.2, 0, 1), (2.0, 1, 2), (3.0, 0, 3))).parting is None
    )


def test_collisions_that_share_a_ball_may_not():
    found = compare_logs(TRUE, hits((1.0, 0, 1), (1.5, 1, 2), (2.0, 2, 3), (3.0, 0, 3)))
    assert found.parting.true == TRUE[1]
    assert found.parting.other == Collision(BALLS, 1, 2, 1.5)
    assert found.parting.t == 1.5
    assert len(found.before) == 1


def test_unless_they_are_at_one_instant_in_either_log():
    stepped = hits((1.0, 0, 1), (1.5, 1, 2), (1.5, 2, 3), (3.0, 0, 3))
    assert compare_logs(TRUE, stepped).parting is None
    assert compare_logs(stepped, TRUE).parting is None


def test_a_missing_and_an_added_collision_are_named():
    missing = compare_logs(TRUE, TRUE[:2] + TRUE[3:])
    assert missing.parting.true == TRUE[2]
    assert missing.parting.other is None
    added = compare_logs(
        TRUE, sorted([*TRUE, Collision(CUSHION, 3, 1, 0.5)], key=lambda one: one.t)
    )
    assert added.parting.true == TRUE[1]  # what ball 3 does in truth
    assert added.parting.other == Collision(CUSHION, 3, 1, 0.5)
    assert added.parting.first == Collision(CUSHION, 3, 1, 0.5)


def test_a_repeated_collision_is_another_one():
    twice = hits((1.0, 0, 1), (2.0, 0, 1))
    assert compare_logs(twice, twice[:1]).parting.true == twice[1]


def test_logs_without_collisions_agree():
    assert compare_logs([], []).parting is None


def test_events_of_other_kinds_are_left_out():
    rows = [(1.0, EventKind.SLIDE_TO_ROLL, 0, -1), (2.0, EventKind.BALL_BALL, 0, 1)]
    events = np.array([(t, int(k), a, b) for t, k, a, b in rows], dtype=EVENT_DTYPE)
    assert collisions_in(events) == [Collision(BALLS, 0, 1, 2.0)]


logs = st.lists(
    st.tuples(st.integers(0, 4), st.integers(0, 4)).filter(lambda pair: pair[0] < pair[1]),
    max_size=12,
).map(lambda pairs: [Collision(BALLS, a, b, 1.0 + k) for k, (a, b) in enumerate(pairs)])


@given(logs, st.randoms())
def test_any_order_that_keeps_each_ball_s_own_agrees_and_no_other(log, random):
    # Swap neighbours without a ball in common, which makes every order of the same trace.
    other = list(log)
    for _ in range(20):
        if len(other) > 1:
            k = random.randrange(len(other) - 1)
            if set(other[k].balls).isdisjoint(other[k + 1].balls):
                other[k], other[k + 1] = other[k + 1], other[k]
    other = [Collision(one.kind, one.a, one.b, 1.0 + k) for k, one in enumerate(other)]
    assert compare_logs(log, other).parting is None
    if log:
        assert compare_logs(log, other[:-1]).parting is not None


@given(logs, logs)
def test_it_says_the_same_as_each_ball_s_own_log(log, other):
    def own(one, ball):
        return [two.key for two in one if ball in two.balls]

    same = all(own(log, ball) == own(other, ball) for ball in range(5))
    assert (compare_logs(log, other).parting is None) == same


@pytest.mark.parametrize("count", [3])
def test_what_comes_after_a_parting_of_other_balls_still_pairs(count):
    true = hits((1.0, 0, 1), (2.0, 2, 3), (3.0, 2, 3), (4.0, 2, 3))
    found = compare_logs(true, true[1:])
    assert len(found.pairs) == count
    assert found.before == ()


BB, BC = int(BALLS), int(CUSHION)
A, B, C, D = (BB, 0, 1), (BB, 1, 2), (BC, 0, 3), (BC, 2, 0)


@pytest.mark.parametrize(
    ("found", "found_times", "true", "times", "leading"),
    [
        ([A, B, C], [1, 2, 3], [A, B, C], [1, 2, 3], 3),
        ([A, B], [1, 2], [A, B, C], [1, 2, 3], 2),  # one missing
        ([A, B, C], [1, 2, 3], [A, B], [1, 2], 2),  # one too many
        ([A, D, B], [1, 2, 3], [A, B], [1, 2], 1),  # one too many in between
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 3], 1),  # order of a ball counts
        ([A, C, B], [1, 2, 3], [A, B, C], [1, 2, 3], 3),  # they share no ball
        ([], [], [A], [1], 0),
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 2], 3),  # tied in truth: no order
        ([A, D, B], [1, 2, 2], [A, B, D], [1, 2, 3], 3),  # one time for both: no order claimed
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 2 * (1 + 1e-13)], 3),  # apart by rounding only
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 2 * (1 + 1e-11)], 1),  # a true order
        ([A, D, B], [1, 2, 3], [A, B, D], [], 1),  # a closed form's order is strict
        ([A, A, D], [1, 1, 2], [A, B, D], [1, 1, 2], 1),  # each true collision serves once
        ([B], [1], [A, B], [1, 1], 0),  # the log ends inside the tie
    ],
)
def test_leading_collisions(found, found_times, true, times, leading):
    logs = (
        collisions_from(true, np.array(times, dtype=float)),
        collisions_from(found, np.array(found_times, dtype=float)),
    )
    assert compare_logs(*logs).leading == leading
