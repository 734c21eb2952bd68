"""The paper's fixed steps, exactly as printed, including the clipping of Figure 2."""

from __future__ import annotations

import math

import pytest
from pydantic import ValidationError
from shots import R

from ghostball.model import Ball, EventKind, Physics, Scene, Status, Table
from ghostball.reference_adapters.paper.discrete import PaperDiscreteEngine, PaperDiscreteSettings

DECELERATION = 0.02 * 9.81
FRICTIONLESS = Physics(rolling_friction=0.0)
TABLE = Table(length=2.54, width=1.27)


def engine(**settings) -> PaperDiscreteEngine:
    return PaperDiscreteEngine(PaperDiscreteSettings(**settings))


def roll(speed: float, **scene) -> Scene:
    cue = Ball(id="cue", position=(0.5, 0.635), velocity=(speed, 0))
    return Scene(name="roll", balls=[cue], **scene)


def head_on(speed: float, start: float = 0.5, **scene) -> Scene:
    cue = Ball(id="cue", position=(start, 0.635), velocity=(speed, 0))
    return Scene(name="head-on", balls=[cue, Ball(id="object", position=(1.2, 0.635))], **scene)


@pytest.mark.parametrize("dt", [0.02, 0.002])
def test_a_roll_stops_half_a_step_short(dt):
    """Semi-implicit Euler loses v dt / 2 of the distance; another integrator would not."""
    result = engine(dt=dt).simulate(roll(1.0), record="events")
    distance = result.rest_positions[0, 0] - 0.5
    expected = 1.0 / (2 * DECELERATION) - 1.0 * dt / 2
    assert distance == pytest.approx(expected, abs=DECELERATION * dt**2)
    assert result.status is Status.REST
    assert result.rest_time == pytest.approx(1.0 / DECELERATION, abs=dt)
    (stop,) = result.events
    assert (stop["kind"], stop["t"]) == (EventKind.ROLL_TO_REST, result.rest_time)


def test_the_error_of_a_roll_is_of_first_order():
    exact = 0.5 + 1.0 / (2 * DECELERATION)
    errors = [exact - engine(dt=dt).simulate(roll(1.0)).rest_positions[0, 0] for dt in (0.02, 0.01)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.01)


def test_head_on_balls_swap_velocities():
    result = engine().simulate(head_on(1.0, t_max=2.0, physics=FRICTIONLESS), record="events")
    assert result.final_state.velocities[0].tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    assert result.collision_counts == {"ball-ball": 1, "ball-cushion": 0}
    assert result.work["pulls"] == 1


def test_overlapping_balls_are_pulled_apart_by_half_each():
    """A contact at 3/4 of a step is detected 1/4 step late; each ball is moved back by half."""
    distance = 1.2 - 0.5 - 2 * R
    speed = distance / (0.02 * 10.75)
    result = engine().simulate(head_on(speed, t_max=0.22, physics=FRICTIONLESS))
    overlap = speed * 0.02 * 0.25
    assert result.rest_positions[:, 0] == pytest.approx(
        [1.2 - 2 * R - overlap / 2 + overlap, 1.2 + overlap / 2], abs=1e-12
    )


def test_figure_2_a_fast_ball_passes_through_another():
    """At 8 m/s a step is 0.16 m, more than the overlap length 4 R, so no collision is detected."""
    scene = head_on(8.0, start=1.2 - 0.16 * 3.5, t_max=0.2, physics=FRICTIONLESS)
    result = engine().simulate(scene)
    assert result.collision_counts["ball-ball"] == 0
    assert result.rest_positions[1].tolist() == [1.2, 0.635, R]
    assert result.rest_positions[0, 0] > 1.2 + 2 * R
    finer = engine(dt=0.005).simulate(scene)
    assert finer.collision_counts["ball-ball"] == 1


def test_figure_2_a_frame_shows_balls_inside_each_other():
    """The frame is rendered before the balls are pulled apart; hiding it would hide the defect."""
    scene = head_on(2.0, start=1.2 - 2 * R - 0.021, t_max=0.2, physics=FRICTIONLESS)
    trajectory = engine().simulate(scene, record="trajectory").trajectory
    gaps = trajectory.positions[:, 1, 0] - trajectory.positions[:, 0, 0] - 2 * R
    assert gaps.min() == pytest.approx(-0.019, abs=1e-12)


def test_once_past_the_centre_a_separating_pair_collides_as_printed():
    """Detected 18 mm late, the balls already separate, but collide in the algorithm as printed."""
    scene = head_on(4.0, start=1.2 - 2 * R - 0.005, t_max=0.02, physics=FRICTIONLESS)
    printed = engine().simulate(scene)
    asking = engine(react="approaching").simulate(scene)
    assert printed.collision_counts["ball-ball"] == 1
    assert printed.final_state.velocities[0, :, 0].tolist() == [0.0, 4.0]
    assert asking.collision_counts["ball-ball"] == 0
    assert asking.work["pulls"] == 1


def test_coincident_centres_are_left_and_counted():
    scene = head_on(4.0, start=1.2 - 0.08, t_max=0.02, physics=FRICTIONLESS)
    result = engine().simulate(scene)
    assert result.rest_positions[0, 0] == result.rest_positions[1, 0]
    assert result.work["coincident_pairs"] == 1


@pytest.mark.parametrize(
    ("cushion", "position", "velocity", "end"),
    [
        (0, (0.14, 0.6), (-2.0, 0.5), (R + 0.08, 0.65)),
        (1, (2.4, 0.6), (2.0, 0.5), (2.54 - R - 0.08, 0.65)),
        (2, (1.0, 0.14), (0.5, -2.0), (1.05, R + 0.08)),
        (3, (1.0, 1.13), (0.5, 2.0), (1.05, 1.27 - R - 0.08)),
    ],
)
def test_a_cushion_mirrors_and_puts_the_ball_back(cushion, position, velocity, end):
    """The ball passes the cushion in the third step, is moved back, and moves inwards two steps."""
    cue = Ball(id="cue", position=position, velocity=velocity)
    scene = Scene(name="wall", balls=[cue], table=TABLE, t_max=0.1, physics=FRICTIONLESS)
    result = engine().simulate(scene, record="events")
    normal = 0 if cushion < 2 else 1
    assert result.final_state.velocities[0, 0, normal] == -velocity[normal]
    assert result.final_state.velocities[0, 0, 1 - normal] == velocity[1 - normal]
    (collision,) = result.events
    assert collision.tolist() == (0.06, EventKind.BALL_CUSHION, 0, cushion)
    assert result.rest_positions[0, :2] == pytest.approx(end)


def test_t_max_is_met_by_a_shorter_last_step():
    result = engine().simulate(roll(1.0, t_max=0.505, physics=FRICTIONLESS), record="trajectory")
    assert (result.status, result.rest_time) == (Status.T_MAX, 0.505)
    assert result.work["steps"] == 26
    assert result.rest_positions[0, 0] == pytest.approx(1.005, abs=1e-14)
    assert result.trajectory.t_end == 0.505


@pytest.mark.parametrize("settings", [{"max_time": 1.0}, {"max_time": 8.0, "stop": "never"}])
def test_a_run_that_does_not_end_says_so(settings):
    """With stop="never", a ball that should rest after 5.1 s still oscillates at 8 s."""
    result = engine(**settings).simulate(roll(1.0))
    assert result.status is Status.STEP_LIMIT
    assert "`max_time`" in result.reason
    assert result.rest_time == settings["max_time"]


@pytest.mark.parametrize(
    "settings",
    [{"dt": 0.0}, {"dt": math.nan}, {"dt": math.inf}, {"react": "no"}, {"stop": "no"},
     {"max_time": -1.0}, {"frame": 0.02}],
)  # fmt: skip
def test_bad_settings_are_refused(settings):
    with pytest.raises(ValidationError):
        engine(**settings)
