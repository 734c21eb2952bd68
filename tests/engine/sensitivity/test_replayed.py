"""Tests of small changes in air and in flight, which the engine computes from perturbed runs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from changes import check_derivatives, directions_of, moved, recorded
from same.images import shuffled
from shots import ball, scene_of

from ghostball.engine.sensitivity import replayed
from ghostball.engine.sensitivity.carried import Carried
from ghostball.engine.sensitivity.replayed import Replayed
from ghostball.model import Ball, EventKind, Physics, Scene
from ghostball.validation.scenes.library import find_scene

SCENES = (
    "air-curves",
    "air-drop",
    "air-paper",
    "air-rolls",
    "cloth-quadratic-sliding",
    "flight-bounces",
    "flight-jaw",
    "flight-leaves",
    "flight-throw",
    "pocket-jump",
    "three-cushions",
)


@pytest.mark.compiled
@pytest.mark.parametrize("name", SCENES)
def test_derivatives_in_air_and_in_flight_agree_with_central_differences(name):
    scene = find_scene(name)
    struck = any(one.strike is not None for one in scene.balls)
    check_derivatives(recorded(scene).at(0.0, name=name) if struck else scene)


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["break-7", "masse", "pocket-draw", "throw-slip", "unequal-balls"])
def test_perturbed_runs_on_the_cloth_agree_with_closed_forms(name):
    """The two methods share no formula."""
    result = recorded(find_scene(name))
    shot = (result.scene, result.trajectory, result.events)
    given = directions_of(result.scene, 3).transpose(1, 2, 0)
    exact, found = Carried(*shot, given), Replayed(*shot, given)
    times = np.linspace(0.03, 0.97, 9) * result.rest_time
    for right, close in zip(exact.known(times), found.known(times), strict=True):
        np.testing.assert_allclose(
            close[:, :2], right[:, :2], rtol=0.0, atol=1e-6 * np.max(np.abs(right[:, :2]))
        )
    shifts = exact.event_shifts
    moving = np.isfinite(found.event_shifts)
    assert np.mean(moving) > 0.8
    allowed = 1e-4 * np.max(np.abs(shifts), axis=1, keepdims=True)
    assert np.all((np.abs(found.event_shifts - shifts) <= allowed)[moving])


@pytest.mark.compiled
def test_event_shifts_in_flight_say_when_events_come():
    scene = find_scene("flight-throw")
    result = recorded(scene)
    change, size = directions_of(scene, 1), 1e-6
    shifts = result.tangent(change).event_shifts[:, 0]
    after, before = (recorded(moved(scene, sign * size * change[0])) for sign in (1, -1))
    difference = (after.events["t"] - before.events["t"]) / (2 * size)
    known = np.isfinite(shifts)
    assert {EventKind.BALL_CLOTH, EventKind.ROLL_TO_REST} <= set(result.events["kind"][known])
    assert difference[known] == pytest.approx(
        shifts[known], rel=1e-3, abs=1e-4 * np.max(np.abs(difference))
    )


def test_a_one_sided_derivative_counts_as_none():
    """A ball that starts at a cushion, towards it, can only be displaced away from it."""
    scene = find_scene("rail-into")
    physics = scene.physics.model_copy(update={"air_drag": 0.01})
    result = recorded(scene.model_copy(update={"physics": physics}))
    assert result.events["t"][0] == 0.0
    tangent = result.tangent(np.ones((1, 1, 7)))
    assert not np.isfinite(tangent.sample([0.5 * result.rest_time])).any()
    assert np.isinf(tangent.growth([0.5 * result.rest_time])).all()
    assert np.isnan(tangent.event_shifts[0]).all()


@pytest.mark.compiled
def test_nothing_is_predicted_past_several_collisions_of_one_ball_in_air():
    scene = find_scene("three-ball-symmetric")
    physics = scene.physics.model_copy(update={"air_drag": 0.01})
    result = recorded(scene.model_copy(update={"physics": physics}))
    t = float(result.events["t"][0])
    assert np.all(np.isfinite(result.sensitivity(t * (1 - 1e-9))))
    assert np.all(np.isinf(result.sensitivity(t + 0.01)))
    assert result.horizon() <= t + 1e-3


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["air-curves", "flight-bounces"])
def test_the_numbering_of_the_balls_does_not_matter_in_air(name):
    result = recorded(find_scene(name))
    order = list(range(len(result.scene.balls)))[::-1]
    other = recorded(shuffled(result.scene, order))
    times = np.linspace(0.0, 1.0, 5) * result.rest_time
    assert other.sensitivity(times) == pytest.approx(result.sensitivity(times)[:, order], rel=1e-4)


def test_a_shot_without_events_has_a_tangent_map():
    scene = scene_of(ball((0.3, 0.5), (0.5, 0.1)), air_drag=0.01, table=None, t_max=0.1)
    result = recorded(scene)
    assert len(result.events) == 0
    change = np.zeros((1, 1, 7))
    change[0, 0, 0] = 1.0
    assert result.tangent(change).sample([0.1])[0, 0, 0, :2] == pytest.approx([1.0, 0.0], abs=1e-7)
    assert result.horizon() == math.inf


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["push", "push-line"])
def test_nothing_is_predicted_past_sustained_contact_in_air(name):
    """Fails if a pushed ball counts as free. A free ball may slide in air, which turns its slip."""
    scene = find_scene(name)
    physics = scene.physics.model_copy(update={"air_drag": 0.01})
    result = recorded(scene.model_copy(update={"physics": physics}))
    assert result.work["contact_steps"] > 0
    assert np.isinf(result.sensitivity([result.rest_time])).any()
    assert result.horizon() < result.rest_time


@pytest.mark.compiled
def test_rounding_of_a_ball_that_stops_leaves_its_changes():
    """A ball that an impact leaves with 1e-16 of the speed counts as at rest."""
    x, y = math.cos(0.1), math.sin(0.1)
    scene = scene_of(
        ball((0.3, 0.3), (0.5 * x, 0.5 * y)),
        ball((0.3 + 0.2 * x, 0.3 + 0.2 * y)),
        motion="rolling",
        rolling_friction=0.0,
        air_drag=0.1,
        t_max=2.0,
    )
    check_derivatives(scene)


def stacked() -> Scene:
    """Return a ball that bounces on another, with thousands of events at short intervals."""
    physics = Physics(preset="pool", airborne=True, ball_restitution=1.0, ball_friction=0.0)
    balls = [
        Ball(id="low", position=(0.0, 0.0, 0.03), radius=0.03, mass=0.2),
        Ball(id="top", position=(0.0, 0.0, 0.0825), velocity=(2e-5, -1e-5, 0.0), radius=0.0225),
    ]
    return Scene(name="stacked", t_max=0.1, physics=physics, balls=balls)


@pytest.mark.compiled
@pytest.mark.parametrize("scene", [stacked(), *map(find_scene, ("flight-jaw", "flight-throw"))])
def test_motion_recorded_once_gives_the_changes_of_motion_simulated_for_each_time(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fails if the recorded motion is read at other times, or ends too early."""
    found = []
    for events in (10**6, 0):
        monkeypatch.setattr(replayed, "_MOST_REPLAYED", events)
        result = recorded(scene)
        found.append(result.sensitivity(np.linspace(0.0, result.rest_time, 33)))
    assert np.isfinite(found[0]).mean() > 0.7
    np.testing.assert_allclose(found[1], found[0], rtol=1e-5)
    assert (len(result.events) > 4000) is (scene.name == "stacked")
