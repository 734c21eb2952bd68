"""Tests of impacts in scenes with flight: between balls, and with the nose of a cushion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from in_space import after_the_first_event, energies_around_events
from recorded import state_at, state_before
from shots import FLIES, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Phase, Table


def test_a_nose_that_rubs_turns_the_ball():
    """Friction at the nose acts against the slip there, and spins a ball that flies along it."""
    scene = scene_of(
        ball((0.1, 0.5, 2.5 * R), (-1, 1, 0), angular_velocity=(0, 0, 0)),
        table=Table(length=2.0, width=1.0),
        cushion="han2005",
        cushion_restitution=0.85,
        cushion_friction=0.2,
        **FLIES,
    )
    event, v, w = after_the_first_event(scene)
    assert event["kind"] == EventKind.BALL_CUSHION
    assert v[0, 0] > 0.0
    assert v[0, 1] < 1.0
    assert w[0, 2] > 0.0  # the cushion slows its left side


@pytest.mark.parametrize(("friction", "sticks"), [(0.05, False), (0.9, True)])
def test_the_friction_of_a_nose_is_that_of_its_whole_impulse(friction, sticks):
    """Coulomb's law with vectors: mu (1 + e) times the approach speed, or 2/7 of the slip."""
    e, h = 0.85, 0.0357
    scene = scene_of(
        ball((0.1, 0.5, 2.2 * R), (-1.0, 0.6, 0.2), angular_velocity=(15.0, -25.0, 40.0)),
        table=Table(length=2.0, width=1.0),
        cushion="han2005",
        cushion_restitution=e,
        cushion_friction=friction,
        cushion_height=h,
        **FLIES,
    )
    result = simulate(scene, record="trajectory")
    event = result.events[0]
    assert event["kind"] == EventKind.BALL_CUSHION
    t = event["t"]
    after = result.sample([t])
    x, _, z = after.positions[0, 0]
    v, w = np.array([-1.0, 0.6, 0.2 - 9.81 * t]), np.array([15.0, -25.0, 40.0])
    normal = np.array([-x, 0.0, h - z]) / math.hypot(x, h - z)  # unit vector towards the nose
    assert math.hypot(x, h - z) == pytest.approx(R, rel=1e-13)
    approach = v @ normal
    slip = v - approach * normal + R * np.cross(w, normal)
    size = np.linalg.norm(slip)
    limit = friction * (1.0 + e) * approach
    assert (limit > 2.0 / 7.0 * size) == sticks
    impulse = -(1.0 + e) * approach * normal - min(limit, 2.0 / 7.0 * size) * slip / size
    assert after.velocities[0, 0] == pytest.approx(v + impulse, abs=1e-12)
    turn = 2.5 / R * np.cross(normal, impulse)
    assert after.angular_velocities[0, 0] == pytest.approx(w + turn, abs=1e-10)


def test_two_unequal_balls_in_flight_share_an_impulse_and_what_turns_them():
    """m v changes by opposite vectors, and m R w by the same vector, 5/2 n x J."""
    masses, radii = np.array([0.3, 0.1]), np.array([0.035, 0.02])
    scene = scene_of(
        ball(
            (0.5, 0.5, 0.12), (1.0, 0.1, 0.5), angular_velocity=(5.0, 20.0, 40.0), radius=radii[0],
            mass=masses[0],
        ),
        ball((0.56, 0.52, 0.14), radius=radii[1], mass=masses[1]),
        ball_friction=0.06,
        **FLIES,
    )  # fmt: skip
    result = simulate(scene, record="trajectory")
    event = result.events[0]
    assert (event["kind"], event["a"], event["b"]) == (EventKind.BALL_BALL, 0, 1)
    before, after = state_before(result, event["t"]), state_at(result, event["t"])
    impulses = masses[:, None] * (after.velocities - before.velocities)
    assert np.linalg.norm(impulses[0]) > 0.01
    assert impulses[0] == pytest.approx(-impulses[1], abs=1e-13)
    normal = (before.positions[1] - before.positions[0]) / radii.sum()
    turns = (masses * radii)[:, None] * (after.angular_velocities - before.angular_velocities)
    assert np.linalg.norm(turns[0]) > 1e-3
    for turn in turns:
        assert turn == pytest.approx(2.5 * np.cross(normal, impulses[0]), abs=1e-12)


def test_a_ball_that_comes_up_from_the_table_yields_to_one_that_falls_on_it():
    """The lower ball moves up when they collide again, slowly; the table doesn't hold it."""
    scene = scene_of(
        ball((0, 0), mass=0.1),
        ball((0, 0, 3.0 * R + 3.7346e-7), mass=0.29076),
        ball_restitution=0.95,
        **(FLIES | {"table_restitution": 0.8427}),
    )
    result = simulate(scene, record="trajectory")
    for kind in (EventKind.BALL_BALL, EventKind.BALL_CLOTH):
        assert np.any(result.events["kind"] == kind)
    energy = energies_around_events(result)
    assert np.diff(energy).max() <= 1e-13 * energy[0]


def test_a_ball_on_the_cloth_meets_the_nose_where_it_is_and_bounces():
    """Contact at sqrt(h (2 R - h)), along the normal in space; pushed down, the ball bounces up."""
    h, e = 0.0357, 0.85
    scene = scene_of(
        ball((0.3, 0.5), (-2, 0)),
        table=Table(length=2.0, width=1.0),
        cushion="restitution",
        cushion_restitution=e,
        **FLIES,
    )
    result = simulate(scene, record="trajectory")
    event = result.events[0]
    assert event["kind"] == EventKind.BALL_CUSHION
    state = result.sample([event["t"]])
    assert state.positions[0, 0, 0] == pytest.approx(math.sqrt(h * (2 * R - h)), rel=1e-13)
    v = result.sample([event["t"] * (1 - 1e-12)]).velocities[0, 0, 0]
    sine = (h - R) / R
    cosine = math.sqrt(1 - sine**2)
    push = (1 + e) * -v * cosine
    # The nose is above the centre, and pushes the ball back and down; the cloth then adds friction.
    back, down = v + push * cosine, push * sine
    slip = back - R * (v / R)
    rubbed = min(0.2 * 1.5 * down, 2 / 7 * slip)
    assert state.velocities[0, 0] == pytest.approx([back - rubbed, 0, 0.5 * down], abs=1e-10)
    assert result.phases([event["t"]])[0, 0] == Phase.FLYING
