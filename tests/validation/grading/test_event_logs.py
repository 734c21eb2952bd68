"""The first difference of two logs: only the order of the events of each ball counts."""

import random

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ghostball.engine import simulate
from ghostball.model import EVENT_DTYPE, EventKind
from ghostball.validation.grading.event_logs import (
    ALL_KINDS,
    Event,
    compare_logs,
    events_from,
    events_in,
)
from ghostball.validation.scenes.library import find_scene

BALLS = EventKind.BALL_BALL
CUSHION = EventKind.BALL_CUSHION


def collisions(*rows):
    return [Event(BALLS, a, b, t) for t, a, b in rows]


TRUE = collisions((1.0, 0, 1), (1.5, 2, 3), (2.0, 1, 2), (3.0, 0, 3))


def test_a_log_agrees_with_itself_and_with_late_times():
    late = collisions((1.1, 0, 1), (1.6, 2, 3), (2.2, 1, 2), (3.4, 0, 3))
    for other in (TRUE, late):
        found = compare_logs(TRUE, other)
        assert found.parting is None
        assert [a for a, _ in found.pairs] == TRUE
        assert found.before == found.pairs


def test_collisions_that_share_a_ball_must_keep_their_order():
    found = compare_logs(TRUE, collisions((1.0, 0, 1), (1.5, 1, 2), (2.0, 2, 3), (3.0, 0, 3)))
    assert found.parting.true == TRUE[1]
    assert found.parting.other == Event(BALLS, 1, 2, 1.5)
    assert found.parting.t == 1.5
    assert len(found.before) == 1


def test_a_missing_and_an_added_collision_are_named():
    missing = compare_logs(TRUE, TRUE[:2] + TRUE[3:])
    assert missing.parting.true == TRUE[2]
    assert missing.parting.other is None
    added = compare_logs(TRUE, sorted([*TRUE, Event(CUSHION, 3, 1, 0.5)], key=lambda one: one.t))
    assert added.parting.true == TRUE[1]  # the reference event of ball 3
    assert added.parting.other == Event(CUSHION, 3, 1, 0.5)
    assert added.parting.first == Event(CUSHION, 3, 1, 0.5)


def test_events_of_other_kinds_are_left_out():
    rows = [(1.0, EventKind.SLIDE_TO_ROLL, 0, -1), (2.0, EventKind.BALL_BALL, 0, 1)]
    events = np.array([(t, int(k), a, b) for t, k, a, b in rows], dtype=EVENT_DTYPE)
    assert events_in(events) == [Event(BALLS, 0, 1, 2.0)]


logs = st.lists(
    st.tuples(st.integers(0, 4), st.integers(0, 4)).filter(lambda pair: pair[0] < pair[1]),
    max_size=12,
).map(lambda pairs: [Event(BALLS, a, b, 1.0 + k) for k, (a, b) in enumerate(pairs)])


@given(logs, st.randoms())
def test_any_order_that_keeps_each_ball_s_own_agrees_and_no_other(log, random):
    # Swaps of neighbours without a common ball produce every equivalent order.
    other = list(log)
    for _ in range(20):
        if len(other) > 1:
            k = random.randrange(len(other) - 1)
            if set(other[k].balls).isdisjoint(other[k + 1].balls):
                other[k], other[k + 1] = other[k + 1], other[k]
    other = [Event(one.kind, one.a, one.b, 1.0 + k) for k, one in enumerate(other)]
    assert compare_logs(log, other).parting is None
    if log:
        assert compare_logs(log, other[:-1]).parting is not None


def test_what_comes_after_a_parting_of_other_balls_still_pairs():
    true = collisions((1.0, 0, 1), (2.0, 2, 3), (3.0, 2, 3), (4.0, 2, 3))
    found = compare_logs(true, true[1:])
    assert len(found.pairs) == 3
    assert found.before == ()


BB, BC = int(BALLS), int(CUSHION)
A, B, C, D = (BB, 0, 1), (BB, 1, 2), (BC, 0, 3), (BC, 2, 0)


@pytest.mark.parametrize(
    ("found", "found_times", "true", "times", "leading"),
    [
        ([A, B, C], [1, 2, 3], [A, B, C], [1, 2, 3], 3),
        ([A, B], [1, 2], [A, B, C], [1, 2, 3], 2),  # one event is missing
        ([A, B, C], [1, 2, 3], [A, B], [1, 2], 2),  # an additional event
        ([A, D, B], [1, 2, 3], [A, B], [1, 2], 1),  # an additional event in between
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 3], 1),  # the order of a ball's events counts
        ([A, C, B], [1, 2, 3], [A, B, C], [1, 2, 3], 3),  # C and B share no ball
        ([], [], [A], [1], 0),
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 2], 3),  # simultaneous in the reference: no order
        ([A, D, B], [1, 2, 2], [A, B, D], [1, 2, 3], 3),  # equal times in the log: no order
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 2 * (1 + 1e-13)], 3),  # equal up to rounding
        ([A, D, B], [1, 2, 3], [A, B, D], [1, 2, 2 * (1 + 1e-11)], 1),  # different times
        ([A, D, B], [1, 2, 3], [A, B, D], [], 1),  # without times, the reference has a strict order
        ([A, A, D], [1, 1, 2], [A, B, D], [1, 1, 2], 1),  # each reference collision has one partner
        ([B], [1], [A, B], [1, 1], 0),  # the log ends among simultaneous events
    ],
)
def test_leading_collisions(found, found_times, true, times, leading):
    logs = (
        events_from(true, np.array(times, dtype=float)),
        events_from(found, np.array(found_times, dtype=float)),
    )
    assert compare_logs(*logs).leading == leading


# --- the strict comparison, for exact engines

KEYS = {
    "A": (BALLS, 0, 1),
    "B": (CUSHION, 2, 0),  # shares no ball with A
    "C": (EventKind.ROLL_TO_REST, 3, -1),  # shares no ball with A or B
    "X": (BALLS, 1, 2),  # shares a ball with A, and one with B
}


def log(text):
    """Return events at 1, 2, 3 ... s; events in brackets are simultaneous."""
    found, t, inside = [], 0.0, False
    for letter in text:
        if letter == "(":
            t, inside = t + 1.0, True
        elif letter == ")":
            inside = False
        else:
            t = t if inside else t + 1.0
            found.append(Event(*KEYS[letter], t, len(found)))
    return found


@pytest.mark.parametrize(
    ("proved", "found", "missing", "invented"),
    [
        ("ABC", "ABC", (), ()),
        ("", "", (), ()),
        ("ABC", "", (0, 1, 2), ()),
        ("", "AB", (), (0, 1)),
        ("ABC", "AC", (1,), ()),
        ("AC", "ABC", (), (1,)),
        ("ABC", "AXC", (1,), (1,)),
        ("AB", "BA", (), ()),  # A and B share no ball: only their times are compared
        ("(AX)C", "XAC", (0, 1), (0, 1)),  # they share a ball: the order counts
        ("(AXB)", "BAX", (1, 2), (0, 2)),  # B must come after X
        ("(AB)", "BXA", (0,), (1, 2)),  # from X on, balls 1 and 2 have wrong collisions
        ("ABABAB", "ABAB", (4, 5), ()),
        ("AAX", "AX", (1, 2), (1,)),
    ],
)
def test_what_has_no_partner(proved, found, missing, invented):
    compared = compare_logs(log(proved), log(found), strict=True)
    assert (compared.missing, compared.invented) == (missing, invented)
    assert (compared.parting is None) == (not missing and not invented)


def test_the_parting_says_what_came_instead():
    scene = find_scene("break-7")
    one, two, three = (ball.id for ball in scene.balls[:3])
    missing = compare_logs(log("ABC"), log("AXC"), strict=True).parting
    assert missing.describe(scene) == (
        f'"{three}" hits the left cushion at t = 2 s is missing from the run; found instead: '
        f'"{two}" hits "{three}" at t = 2 s'
    )
    extra = compare_logs(log("A"), log("AB"), strict=True).parting
    assert extra.describe(scene).endswith("reference: no further event of these balls")
    again = compare_logs(log("A"), log("AA"), strict=True).parting
    assert again.describe(scene).startswith(
        f'"{one}" hits "{two}" at t = 2 s is not in the reference'
    )


def test_thousands_of_events_that_repeat_themselves():
    # Two events alternate, as in Galperin's billiard; the other log lacks the last two.
    whole = log("AX" * 15_000)
    compared = compare_logs(whole, whole[:-2], strict=True)
    assert compared.missing == (29_998, 29_999)
    assert compared.invented == ()


def test_the_lower_ball_comes_first_in_a_log():
    events = simulate(find_scene("half-ball-cut"), record="events").events
    swapped = events.copy()
    swapped["a"][0], swapped["b"][0] = events["b"][0], events["a"][0]
    assert events_in(swapped, ALL_KINDS) == events_in(events, ALL_KINDS)


def test_events_keep_their_places_where_some_kinds_are_left_out():
    events = simulate(find_scene("follow-shot"), record="events").events
    for one in events_in(events):
        assert events["t"][one.index] == one.t


def test_random_logs_are_paired_alike_each_once_and_in_the_order_of_each_ball():
    chance = random.Random("logs")
    for _ in range(400):
        one, other = (log("".join(chance.choices("ABCX", k=chance.randrange(12)))) for _ in "12")
        found = compare_logs(one, other, strict=True)
        assert all(one[i].key == other[j].key for i, j in found.index_pairs)
        assert sorted([*(i for i, _ in found.index_pairs), *found.missing]) == [*range(len(one))]
        assert sorted([*(j for _, j in found.index_pairs), *found.invented]) == [*range(len(other))]
        for k, (i, j) in enumerate(found.index_pairs):
            for p, q in found.index_pairs[:k]:
                if set(one[i].balls) & set(one[p].balls):
                    assert (p < i) == (q < j)
