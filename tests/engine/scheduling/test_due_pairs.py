"""Tests of the order of two simultaneous events, in both schedulers."""

import pytest
from many_balls import by_both
from recorded import fingerprint
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.model import EventKind, Table


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("cushion_first", [False, True])
def test_a_balls_own_event_comes_before_a_contact_of_the_same_instant(
    monkeypatch, turned, cushion_first
):
    """This also holds while the bound of the pair is advanced, in the slot of either ball."""
    gap = 0.25  # [m], to the cushion and to the ball ahead, which are reached simultaneously
    mover = ball((0.5, R + gap), (1.0, -1.0))
    ahead = ball((0.5 + gap + (R if cushion_first else 2 * R), R))
    balls = [ahead, mover] if turned else [mover, ahead]
    scene = scene_of(*balls, table=POOL_TABLE)
    paired, celled = by_both(scene, monkeypatch)
    assert fingerprint(paired) == fingerprint(celled)


@pytest.mark.parametrize("turned", [False, True])
def test_a_rest_comes_before_a_cushion_hit_at_the_same_time(monkeypatch, turned):
    """The log is ordered by kind, for any numbering of the balls. All numbers here are exact."""
    rests = ball((2.0, 0.5), (1.0, 0.0), radius=0.25)  # slowed by 1 m/s^2: at t = 1 s
    bounces = ball((1.25, 2.0), (-1.0, 0.0), radius=0.25, rolling_friction=0.0)  # over 1 m
    balls = [bounces, rests] if turned else [rests, bounces]
    table = Table(length=8.0, width=4.0)
    scene = scene_of(*balls, table=table, gravity=8.0, rolling_friction=0.125, t_max=1.5)
    for result in by_both(scene, monkeypatch):
        assert result.events["t"].tolist() == [1.0, 1.0]
        kinds = [EventKind.ROLL_TO_REST, EventKind.BALL_CUSHION]
        assert [EventKind(kind) for kind in result.events["kind"]] == kinds
        assert result.events["a"].tolist() == ([1, 0] if turned else [0, 1])
