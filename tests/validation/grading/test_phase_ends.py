"""The ends of slides and rolls in a run are compared with the proof, even if the run omits some."""

from __future__ import annotations

import pytest

from ghostball.model import EventKind
from ghostball.validation.grading.event_logs import Event
from ghostball.validation.grading.phase_ends import phase_ends

HIT, BOUNCE = EventKind.BALL_BALL, EventKind.BALL_CUSHION
ROLLS, RESTS = EventKind.SLIDE_TO_ROLL, EventKind.ROLL_TO_REST

Row = tuple[float, EventKind, int, int]

CERTIFICATE: list[Row] = [
    (0.5, ROLLS, 0, -1),
    (1.0, HIT, 0, 1),
    (1.25, ROLLS, 0, -1),
    (1.5, ROLLS, 1, -1),
    (2.0, RESTS, 0, -1),
    (3.0, BOUNCE, 1, 0),
    (3.125, ROLLS, 1, -1),
    (5.0, RESTS, 1, -1),
]


def log(rows: list[Row]) -> list[Event]:
    return [Event(kind, a, b, t, k) for k, (t, kind, a, b) in enumerate(sorted(rows))]


def late_by(found: list[Row], end: float = 5.0) -> dict[float, float]:
    """Return the delay of each proved end, by the time of the end."""
    return {one.true.t: one.late_by for one in phase_ends(log(CERTIFICATE), log(found), end)}


def changed(old: Row, *new: Row) -> list[Row]:
    return [one for one in CERTIFICATE if one != old] + list(new)


def test_who_reports_the_proof_is_right() -> None:
    assert late_by(CERTIFICATE) == dict.fromkeys((0.5, 1.25, 1.5, 2.0, 3.125, 5.0), 0.0)


@pytest.mark.parametrize("by", [0.25, -0.125])
def test_an_end_that_comes_late_or_early_is_off_by_that(by: float) -> None:
    found = late_by(changed(CERTIFICATE[2], (1.25 + by, ROLLS, 0, -1)))
    assert found.pop(1.25) == abs(by)
    assert set(found.values()) == {0.0}


def test_an_end_that_is_missing_is_at_the_nearest_collision() -> None:
    # The collision before the end, at 1 s, is nearest: as if the ball had rolled at once.
    assert late_by([one for one in CERTIFICATE if one[:3] != (1.5, ROLLS, 1)])[1.5] == 0.5
    # The collision after the end is nearest; the run has it early.
    rests = (2.875, BOUNCE, 1, 0)
    found = [one for one in changed(CERTIFICATE[5], rests) if one[:3] != (1.5, ROLLS, 1)]
    assert late_by(found)[1.5] == 0.5


def test_an_end_that_is_missing_is_no_later_than_the_collision_after_it() -> None:
    # The run has the cushion collision at 1.375 s, before the proved end at 1.5 s.
    found = [one for one in changed(CERTIFICATE[5], (1.375, BOUNCE, 1, 0)) if one != CERTIFICATE[3]]
    assert late_by(found)[1.5] == 0.125
    # The same applies if the run ends earlier.
    assert late_by(CERTIFICATE[:-1], end=4.5)[5.0] == 0.5


def test_a_slide_may_end_as_the_ball_rests() -> None:
    assert late_by([one for one in CERTIFICATE if one != CERTIFICATE[2]])[1.25] == 0.75


def test_of_several_ends_the_worst_counts() -> None:
    # A ball that jitters at rest may come to rest twice, but not much later.
    assert late_by([*CERTIFICATE, (2.25, RESTS, 0, -1)])[2.0] == 0.25
    assert late_by([*CERTIFICATE, (1.75, RESTS, 0, -1)])[2.0] == 0.25
    # An end in the time step of a collision may be reported before or after the collision.
    assert late_by(changed(CERTIFICATE[2], (1.0, ROLLS, 0, -1)))[1.25] == 0.25


def test_an_end_that_the_proof_lacks_says_nothing() -> None:
    assert set(late_by([*CERTIFICATE, (2.5, RESTS, 1, -1)]).values()) == {0.0}


def test_kinds_that_a_run_never_reports_are_left_out() -> None:
    assert set(late_by([one for one in CERTIFICATE if one[1] is not ROLLS])) == {2.0, 5.0}
    assert late_by([one for one in CERTIFICATE if one[1] in (HIT, BOUNCE)]) == {}


def test_nothing_is_compared_after_a_collision_that_one_of_the_two_lacks() -> None:
    without = [one for one in CERTIFICATE if one[1] is not BOUNCE]
    assert set(late_by(without)) == {0.5, 1.25, 2.0}
    assert set(late_by([*CERTIFICATE, (4.0, BOUNCE, 0, 1)])) == {0.5, 1.5, 3.125, 5.0}
