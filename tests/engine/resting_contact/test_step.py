"""Tests of resting contact: its end in closed form, and the requirements on a step."""

import numpy as np
import pytest
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.engine.running import driver
from ghostball.model import Ball, EventKind, Physics, Scene, Status
from ghostball.model.rounding import CONTACT_TOLERANCE
from ghostball.validation.runs.sampling import overlaps_at_cushions, overlaps_of_balls
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import closed_form


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
    """The overlap is largest at 4/5 of a step; with earlier checks only, it was 8 % larger."""
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
    deepest = np.maximum(
        overlaps_of_balls(scene, positions), overlaps_at_cushions(scene, positions)
    )
    assert deepest.max() <= 2 * radius * CONTACT_TOLERANCE + rounding


def test_a_slow_ball_that_is_pushed_is_not_stopped_again_and_again():
    """If it were stopped in each step, the neighbours' forces wouldn't fit its motion."""
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
    """A contact that stops balls logs an event for each ball; the log must have room for all."""
    scene = kept_scene("stopped-by-contact")
    whole = simulate(scene, record="events")
    # The log also needs room for the largest number of bounces in a corner.
    monkeypatch.setattr(driver, "_FIRST_LOG", MOST_IN_CORNER + first_log)
    again = simulate(scene, record="events")
    assert np.array_equal(again.events, whole.events)
    for found, expected in zip(again.trajectory.segments, whole.trajectory.segments, strict=True):
        assert np.array_equal(found, expected)


# --- closed forms for shots whose certified result ends early, at a tie or a resting contact


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
    """The limits [m] and [s] are those of the scene, which states the reasons."""
    scene = find_scene(name)
    form, result = closed_form(scene), simulate(scene)
    assert form is not None
    places = np.array([[float(x), float(y)] for x, y in form.rest_positions])
    assert np.max(np.abs(result.rest_positions[:, :2] - places)) <= distance
    assert abs(result.rest_time - float(form.rest_time)) <= duration
    assert dict(result.collision_counts) == form.collision_counts
