"""The operators of oblique hits and throw reproduce closed forms and published models."""

from __future__ import annotations

import math
from functools import partial

import pytest

from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.validation.measured.oblique_hits import oblique_hit, passed_throw, throw_angle
from ghostball.validation.measured.simulated_ball import OperatorError

PLAY = partial(simulate, record="trajectory")
CLOTH = {
    "motion": "sliding",
    "rolling_friction": 0.0128,
    "sliding_friction": 0.21,
    "spinning_friction_rate": 22.0,
}


@pytest.mark.parametrize(("speed", "cut"), [(0.942, 18.05), (1.539, 33.83), (1.731, 46.5)])
def test_elastic_balls_without_friction_do_as_wallace_and_schroeder_say(speed, cut):
    hit = oblique_hit(PLAY, Physics(**CLOTH), speed, cut)
    sine, cosine = math.sin(math.radians(cut)), math.cos(math.radians(cut))
    cue = 5.0 / 7.0 * speed * math.sqrt(9.0 / 5.0 * sine**2 + 4.0 / 25.0)
    assert hit.cue_speed == pytest.approx(cue, rel=1e-3)
    assert hit.object_speed == pytest.approx(5.0 / 7.0 * speed * cosine, rel=1e-3)
    deflection = math.degrees(math.atan2(sine * cosine, sine**2 + 0.4))
    assert hit.cue_angle == pytest.approx(deflection, abs=0.01)
    assert hit.object_angle == pytest.approx(cut, abs=0.01)


@pytest.mark.parametrize(
    ("speed", "cut", "expected"),
    [(1.539, 33.83, (0.914, 0.831, 31.93, 32.20)), (1.032, 26.36, (0.520, 0.599, 32.45, 25.07))],
)
def test_mathavan_s_own_model_is_read_as_he_printed_it(speed, cut, expected):
    law = {"ball_impact": "mathavan2014", "ball_restitution": 0.89, "ball_friction": 0.05}
    hit = oblique_hit(PLAY, Physics(**CLOTH, **law), speed, cut)
    assert (hit.cue_speed, hit.object_speed) == pytest.approx(expected[:2], abs=1e-3)
    assert (hit.cue_angle, hit.object_angle) == pytest.approx(expected[2:], abs=0.015)


@pytest.mark.parametrize("cut", [30.0, 45.0])
def test_a_contact_that_sticks_throws_by_a_seventh_of_the_cut(cut):
    physics = Physics(motion="sliding", ball_friction=5.0)
    limit = math.degrees(math.atan(math.tan(math.radians(cut)) / 7.0))
    assert throw_angle(PLAY, physics, 2.0, cut) == pytest.approx(limit, abs=0.03)


def test_throw_is_what_friction_makes_of_it():
    assert throw_angle(PLAY, Physics(motion="sliding"), 2.0, 30.0) == pytest.approx(0.0, abs=1e-6)
    rough, smooth = (
        throw_angle(PLAY, Physics(motion="sliding", ball_friction=mu), 2.0, 45.0)
        for mu in (0.06, 0.03)
    )
    assert rough == pytest.approx(math.degrees(math.atan(0.06)), abs=0.03)
    assert smooth == pytest.approx(math.degrees(math.atan(0.03)), abs=0.03)


@pytest.mark.parametrize("gap", [0.0, 1e-4, 3e-3])
@pytest.mark.parametrize("angle", [30.0, 45.0])
def test_a_ball_passes_throw_on(angle, gap):
    """A ball after a full hit slides, so it throws the next ball as a cue ball would."""
    smooth = passed_throw(PLAY, Physics(motion="sliding"), 1.0, angle, gap)
    assert smooth == pytest.approx(0.0, abs=2e-3)
    rough = passed_throw(PLAY, Physics(motion="sliding", ball_friction=0.05), 1.0, angle, gap)
    assert rough == pytest.approx(math.degrees(math.atan(0.05)), abs=0.05)


def test_a_second_ball_that_is_not_reached_is_said():
    with pytest.raises(OperatorError, match=r"doesn't move after a hit at 0\.1 m/s"):
        passed_throw(PLAY, Physics(motion="sliding"), 0.1, 30.0, 0.02)
