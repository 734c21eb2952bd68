"""Sustained contact: its ends in closed form, and what a step of it must keep to."""

import math

import numpy as np
import pytest
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.core.tolerances import CONTACT_TOLERANCE, EPS
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.engine.running import driver
from ghostball.model import Ball, EventKind, Physics, Scene, Status
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress.invariants import overlaps
from ghostball.validation.truth.closed_forms import closed_form

R = 0.028575


def largest_overlap(scene, result, samples=20_001):
    positions = result.sample(np.linspace(0.0, result.rest_time, samples)).positions[:, :, :2]
    radii = scene.radii
    return max(
        np.max(radii[i] + radii[j] - np.hypot(*(positions[:, i] - positions[:, j]).T))
        for i in range(len(radii))
        for j in range(i)
    )


@pytest.mark.parametrize("n", [5, 7])
def test_a_gap_that_opens_before_it_closes_stays_within_the_tolerance(n):
    """Its overlap is largest at four fifths of a step; looked at no later, it was 8 % more."""
    radius = 2.0**-5
    line = [Ball(id=f"b{k}", radius=radius, position=(2 * radius * k, 0.0)) for k in range(n)]
    cue = Ball(id="cue", radius=radius, position=(-0.125, 0.25 * radius), velocity=(1.5, 0.0))
    physics = Physics(motion="sliding", ball_restitution=0.95, ball_friction=0.06)
    scene = Scene(name="line", physics=physics, t_max=0.2, balls=[cue, *line])
    result = simulate(scene, record="events")
    starts = np.unique(np.concatenate([of[:, 0] for of in result.trajectory.segments]))
    parts = np.arange(16) / 16
    times = (starts[:-1, np.newaxis] + np.diff(starts)[:, np.newaxis] * parts).ravel()
    positions = result.sample(times).positions
    rounding = 16 * EPS * np.max(np.abs(positions))
    assert overlaps(scene, positions).max() <= 2 * radius * CONTACT_TOLERANCE + rounding


def test_a_slow_ball_that_is_pushed_is_not_stopped_again_and_again():
    """Stopping it each step moved it off the motion that its neighbours' forces were made for."""
    scene = kept_scene("pushed-slow-ball")
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    assert np.count_nonzero(result.events["kind"] == EventKind.ROLL_TO_REST) <= len(scene.balls)
    assert largest_overlap(scene, result) < 1e-12


def test_the_run_ends_when_the_last_ball_stops_also_where_a_contact_stops_it():
    scene = kept_scene("stopped-by-contact")
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    end = result.sample([result.rest_time])
    assert not np.any(end.velocities)
    assert np.array_equal(end.positions[0], result.rest_positions)


@pytest.mark.parametrize("first_log", range(1, 24))
def test_an_instant_with_several_events_fits_in_any_log(first_log, monkeypatch):
    """A contact that stops balls logs an event for each; the log must have room for all."""
    scene = kept_scene("stopped-by-contact")
    whole = simulate(scene, record="events")
    # Beyond what a corner might fill, which no log may be without.
    monkeypatch.setattr(driver, "_FIRST_LOG", MOST_IN_CORNER + first_log)
    again = simulate(scene, record="events")
    assert np.array_equal(again.events, whole.events)
    for found, expected in zip(again.trajectory.segments, whole.trajectory.segments, strict=True):
        assert np.array_equal(found, expected)


@pytest.mark.parametrize("motion", ["sliding", "rolling"])
@pytest.mark.parametrize("n", [2, st.MOST_DIRECT + 2], ids=["followed", "in steps"])
def test_a_line_that_rolls_in_air_is_slowed_as_a_whole(n, motion):
    """Closed form: each pushes the next, which more friction slows; and air takes alike from all.

    p' = -(a + b p^2), a the mean of the frictions, b what rolling friction has with the square of
    the speed and, of the air, what the cloth leaves.
    """
    frictions, v, t = np.linspace(0.01, 0.03, n), 2.0, 0.05
    physics = Physics(
        motion=motion,
        air_drag=0.05,
        rolling_friction_quadratic=0.05,
        **({"ball_friction": 0.0} if motion == "sliding" else {}),
    )
    balls = [
        Ball(id=f"b{k}", position=(2 * R * k, 0.0), velocity=(v, 0.0), rolling_friction=friction)
        for k, friction in enumerate(frictions)
    ]
    result = simulate(Scene(name="line", balls=balls, physics=physics, t_max=t), record="events")
    assert result.work["contact_steps"] > 2
    assert (result.work.get("contact_pieces", 0) > 0) == (n == 2)
    a, b = 9.81 * np.mean(frictions), 0.05 * (1.0 + (5.0 / 7.0 if motion == "sliding" else 1.0))
    first = np.arctan(v * np.sqrt(b / a))
    last = first - np.sqrt(a * b) * t
    end = result.sample([t])
    off = 1e-6 if n == 2 else 2e-5
    gone = end.positions[0, :, 0] - [ball.position[0] for ball in balls]
    assert end.velocities[0, :, 0] == pytest.approx(np.sqrt(a / b) * np.tan(last), rel=0.0, abs=off)
    assert gone == pytest.approx(np.log(np.cos(last) / np.cos(first)) / b, rel=0.0, abs=off * t)


# --- where a proof ends early, at a tie or in lasting contact: closed forms


@pytest.mark.parametrize(
    ("name", "distance", "duration"),
    [
        ("corner-exact", 1e-14, 1e-14),
        ("frozen-to-cushion", 1e-14, 1e-14),
        ("three-ball-symmetric", 1e-14, 1e-14),
        ("push", 1e-6, 5e-6),
        ("wedged", 1e-12, 1e-5),
    ],
)
def test_a_shot_ends_as_its_closed_form_says(name, distance, duration):
    """Within [m] and [s] what the scene's own criteria say, and why."""
    scene = find_scene(name)
    form, result = closed_form(scene), simulate(scene)
    assert form is not None
    places = np.array([[float(x), float(y)] for x, y in form.rest_positions])
    assert np.max(np.abs(result.rest_positions[:, :2] - places)) <= distance
    assert abs(result.rest_time - float(form.rest_time)) <= duration
    assert dict(result.collision_counts) == form.collision_counts


def test_a_pushed_ball_parts_where_the_other_is_slowed_more():
    """Of a ball that pushes another until it rolls, and then is slowed more: the contact opens.

    While it slides, both go with (5 mu_s - 7 mu_f) g / 12, mu_f the rolling friction of the front
    ball, as in the shipped scene `push`; the slide ends where a t = R w - (5/2) mu_s g t. From
    there each rolls out alone.

    Our engine ends a slip at once that the cloth would end within `STOP_DISTANCE`: one of up to
    sqrt(2 mu_s g 2e-10 m) = 3e-5 m/s, of which 2/7 come off the rear ball alone instead of off
    both: 8e-6 m/s, worth v dv / (mu_r g) = 8 um in its roll out.
    """
    push = find_scene("push")
    rear, front = push.balls
    braked = rear.model_copy(update={"rolling_friction": 0.04})
    scene: Scene = push.model_copy(update={"name": "parting", "balls": (braked, front)})
    g, slide = scene.physics.gravity, float(scene.sliding_frictions[0])
    of_front = float(scene.rolling_frictions[1])
    together = (5.0 * slide - 7.0 * of_front) * g / 12.0
    rolls = rear.radius * float(scene.angular_velocities[0, 1]) / (together + 2.5 * slide * g)
    speed = together * rolls
    ways = 0.5 * speed * rolls + speed * speed / (2.0 * scene.rolling_frictions * g)
    result = simulate(scene)
    off = result.rest_positions[:, 0] - scene.positions[:, 0] - ways
    assert ways[1] - ways[0] > 4.0 * rear.radius
    assert np.max(np.abs(off)) <= 1e-5
    assert math.isclose(result.rest_time, rolls + speed / (of_front * g), abs_tol=5e-6)
    assert not any(result.collision_counts.values())
