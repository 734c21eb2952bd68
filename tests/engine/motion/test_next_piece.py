"""Tests of a ball on the cloth up to its next collision: closed forms and published numbers.

The exact numbers are computed with mpmath from the doubles of the scene, so only the rounding of
the engine remains. [3.3], [A.16] and [B.6] are technical proofs of D. Alciatore
(billiards.colostate.edu/technical_proofs). Squirt is left out: it is an effect of the cue, and here
balls start with given velocities.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from digits import assert_close, deceleration, forty_digits  # noqa: F401 - for all tests
from mpmath import mp, mpf
from recorded import EPS, direction, speed, state_at, state_before, times_of
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Status, Table

FOOT, INCH, MILE_PER_HOUR = 0.3048, 0.0254, 0.44704
CLOTH = {"motion": "sliding", "rolling_friction": 0.01, "sliding_friction": 0.2}


def once_rolling(result, ball, since=0.0):
    """Return when a ball first starts to roll after `since` [s], and its velocity (2,) then."""
    t = next(t for t in times_of(result, EventKind.SLIDE_TO_ROLL, ball) if t > since)
    return t, state_at(result, t).velocities[ball, :2]


def printed(value: float, published: float) -> None:
    """Assert that a value agrees with a printed number with three decimals."""
    assert abs(value - published) <= (0.5 + 1e-6) * 1e-3, f"{value}, printed {published}"


@pytest.mark.parametrize("v", [1e-9, 1.0, 1e4])
@pytest.mark.parametrize("friction", [0.005, 0.02, 1.0])
def test_a_ball_stops_where_and_when_it_must(v, friction):
    scene = scene_of(ball((0, 0), (v, 0)), rolling_friction=friction)
    result = simulate(scene, record="events")
    a = deceleration(scene)
    assert result.status is Status.REST
    assert_close(result.rest_time, mpf(v) / a, 3)
    assert_close(result.rest_positions[0, 0], mpf(v) ** 2 / (2 * a), 4)
    assert result.rest_positions[0, 1:].tolist() == [0.0, R]
    assert result.events["kind"].tolist() == [EventKind.ROLL_TO_REST]


def test_a_slide_and_the_roll_after_it_are_on_their_parabolas():
    """Another engine with a time step of 1/512 s has errors of 3.8 mm at 1 s and 28 mm at rest."""
    velocity, spin = (1.3, 0.4), (35.0, -20.0, 15.0)
    scene = scene_of(ball((0.0, 0.0), velocity, angular_velocity=spin), **CLOTH)
    result = simulate(scene, record="events")
    g, radius = mpf(9.81), mpf(R)
    slide, roll = mpf(0.2) * g, mpf(0.01) * g
    v = [mpf(c) for c in velocity]
    slip = [v[0] - radius * mpf(spin[1]), v[1] + radius * mpf(spin[0])]
    size = mp.hypot(*slip)
    t1 = 2 * size / (7 * slide)
    place = [v[k] * t1 - slide * slip[k] / size * t1**2 / 2 for k in (0, 1)]
    v = [v[k] - 2 * slip[k] / 7 for k in (0, 1)]
    fast = mp.hypot(*v)
    assert once_rolling(result, 0)[0] == pytest.approx(float(t1), rel=8 * EPS)
    for t in (mpf(1), t1 + fast / roll):
        s = t - t1
        exact = [float(place[k] + v[k] * s - roll * v[k] / fast * s**2 / 2) for k in (0, 1)]
        found = result.sample([float(t)]).positions[0, 0, :2]
        assert found == pytest.approx(exact, abs=32 * EPS * 10)
    assert result.rest_positions[0, :2] == pytest.approx(exact, abs=32 * EPS * 10)


# --- published: a rolling cue ball hits a resting ball, elastically and without friction


def rolling_velocities(cut: float, v: float = 1.5) -> tuple[float, list[np.ndarray]]:
    """Return when both balls roll after a collision, and their velocities.

    The cue ball hits the object ball `cut` [rad] off the line of centres. The velocities are
    divided by the speed of the cue ball before.
    """
    target = (2 * R * math.cos(cut), 2 * R * math.sin(cut))
    result = simulate(scene_of(ball((-0.3, 0.0), (v, 0.0)), ball(target), **CLOTH), record="events")
    collision = times_of(result, EventKind.BALL_BALL)[0]
    before = speed(state_before(result, collision).velocities[0])
    (cue_rolls, cue), (rolls, struck) = (once_rolling(result, i, since=collision) for i in (0, 1))
    assert cue_rolls == pytest.approx(rolls, rel=1e-13)
    return rolls, [cue / before, struck / before]


@pytest.mark.parametrize(
    ("cut", "published"),
    [
        (10, 21.681),
        (math.degrees(math.asin(0.25)), 27.626),
        (20, 31.868),
        (28.126, 33.749),  # the largest
        (30, 33.670),
        (40, 31.196),
        (math.degrees(math.asin(0.75)), 27.267),
        (60, 20.633),
        (80, 7.116),
    ],
)
def test_a_rolling_cue_ball_is_deflected_as_published(cut, published):
    """[3.3], [A.16]: the thirty-degree rule."""
    _, (cue, _) = rolling_velocities(math.radians(cut))
    printed(abs(direction(cue)), published)


def test_speeds_after_a_thirty_degree_cut():
    _, (cue, struck) = rolling_velocities(math.radians(30))
    printed(100 * speed(struck), 61.859)
    printed(100 * speed(cue), 55.787)


@pytest.mark.parametrize(("cut", "v"), [(5, 0.5), (30, 4.0), (45, 0.5), (70, 4.0)])
def test_final_speeds_and_one_instant_for_both_slides(cut, v):
    _, (cue, struck) = rolling_velocities(math.radians(cut), v)
    s, c = math.sin(math.radians(cut)), math.cos(math.radians(cut))
    assert speed(struck) == pytest.approx(5 / 7 * c, rel=1e-13)
    assert speed(cue) == pytest.approx(5 / 7 * math.sqrt(9 / 5 * s**2 + 4 / 25), rel=1e-13)


@pytest.mark.parametrize(("mph", "feet"), [(1.5, 7.522), (7, 25.041), (20, 39.291)])
def test_how_far_a_ball_goes_up_and_down_a_nine_foot_table(mph, feet):
    """[B.6] 100 inches between cushions; each cushion takes 0.3 of the speed and all spin.

    No law of the engine takes all spin, so each leg is simulated separately: it starts with 0.7 of
    the speed at the cushion, and slides.
    """
    leg = 100 * INCH
    v, spin, travelled = mph * MILE_PER_HOUR, {}, 0.0
    while True:
        scene = scene_of(
            ball((0.0, 0.5), (v, 0.0), **spin),
            table=Table(length=leg + R, width=1.0, cushions=("right",)),
            gravity=9.80665,
            **CLOTH,
        )
        result = simulate(scene, record="events")
        meets = times_of(result, EventKind.BALL_CUSHION)
        if not meets:
            break
        travelled += leg
        v = 0.7 * speed(state_before(result, meets[0]).velocities[0])
        spin = {"angular_velocity": (0.0, 0.0, 0.0)}
    printed((travelled + result.rest_positions[0, 0]) / FOOT, feet)
