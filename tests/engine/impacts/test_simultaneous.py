"""Tests of simultaneous impacts, against closed forms and published numbers.

The stress suite tests with random scenes, including racks and corners, that no side and no
numbering of the balls is favoured, to the bit ("renumbered", "mirrored").

Two published results have other tests: `test_compliant.py` has the cradle of three Hertzian balls,
which touch all at once for a while, and `test_pressure_of_discs.py` the equation of state of hard
discs.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from recorded import EPS, collisions, fingerprint, speed, state_at, state_before, times_of
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Samples, energy_of

BALL_BALL = EventKind.BALL_BALL
ROOT3 = math.sqrt(3)

ROLLING = {"motion": "rolling"}
SLIDING = {"motion": "sliding", "rolling_friction": 0.01}
PHYSICS = {
    "rolling": ROLLING,
    "rolling, e = 0.9": {**ROLLING, "ball_restitution": 0.9},
    "sliding": SLIDING,
    "sliding, e = 0.95, friction": {**SLIDING, "ball_restitution": 0.95, "ball_friction": 0.06},
    "sliding, e = 0.9, speed-dependent": {
        **SLIDING,
        "ball_restitution": 0.9,
        "ball_friction": "alciatore",
    },
    "sliding, cloth in impacts": {
        **SLIDING,
        "ball_impact": "mathavan2014",
        "ball_restitution": 0.89,
        "ball_friction": 0.05,
    },
}
every_physics = pytest.mark.parametrize("physics", PHYSICS.values(), ids=PHYSICS.keys())


PAIR = (ball((ROOT3 * R, R)), ball((ROOT3 * R, -R)))
"""Two touching balls; a third ball, moving along x, touches both simultaneously."""


@every_physics
@pytest.mark.parametrize("masses", [(0.17, 0.17, 0.17), (0.1, 0.2, 0.4)])
def test_a_joint_impact_keeps_momentum_gains_no_energy_and_leaves_no_approach(physics, masses):
    scene = scene_of(
        ball((0.0, 0.0), (2.0, 0.1), mass=masses[0]),
        ball((ROOT3 * R, R), mass=masses[1]),
        ball((ROOT3 * R, -R), mass=masses[2]),
        **physics,
    )
    result = simulate(scene, record="events")
    t = times_of(result, BALL_BALL)[0]
    assert t <= EPS
    before, after = state_before(result, 0.0), state_at(result, t)
    momenta = [scene.masses @ state.velocities[:, :2] for state in (before, after)]
    if physics.get("ball_impact") != "mathavan2014":  # in this law, the cloth acts, too
        assert momenta[1] == pytest.approx(momenta[0], abs=16 * EPS * 2.0 * sum(masses))
    first, last = energy_of(scene, Samples(*map(np.stack, zip(before, after, strict=True)))).total
    assert last <= first * (1 + 16 * EPS)
    e, friction = physics.get("ball_restitution", 1.0), physics.get("ball_friction", 0.0)
    if e == 1.0 and friction == 0.0:
        assert last == pytest.approx(first, rel=32 * EPS)
    for j in (1, 2):
        r = (after.positions[j] - after.positions[0])[:2]
        v = (after.velocities[j] - after.velocities[0])[:2]
        assert r @ v >= -64 * EPS * R


@pytest.mark.parametrize("restitution", [1.0, 0.5])
@pytest.mark.parametrize("friction", [0.02, 0.3])
def test_friction_acts_against_the_mean_slip_of_a_joint_impact(restitution, friction):
    """A ball slides without friction into two balls; the impulses are computed by hand.

    Friction acts against the mean of the slips before and after the normal impulses. If friction
    acted against the slip afterwards, which is reversed here for e = 1, it would add energy.
    """
    e, v = restitution, 1.5
    scene = scene_of(
        ball((-0.2, 0.0), (v, 0.0), angular_velocity=(0.0, 0.0, 0.0)),
        *PAIR,
        t_max=0.2,
        motion="sliding",
        sliding_friction=0.0,
        rolling_friction=0.0,
        spinning_friction_rate=0.0,
        ball_restitution=e,
        ball_friction=friction,
    )
    result = simulate(scene, record="events")
    assert list(result.events["kind"]) == [BALL_BALL, BALL_BALL]
    assert result.work["joint_impacts"] == 1
    # Impulse of each contact over the mass of a ball; by symmetry, both are the same.
    sine, cosine = 0.5, math.sqrt(0.75)
    normal = (1.0 + e) * v * cosine / 2.5
    slip = v * sine - normal * cosine * sine  # the mean of v sin and (v - 2 normal cos) sin
    tangential = min(friction * normal, slip / 3.0 / 3.5)  # each contact has half of the cue
    normal = ((1.0 + e) * v * cosine - 2.0 * tangential * sine * cosine) / 2.5
    end = result.final_state
    left = v - 2.0 * (normal * cosine + tangential * sine)
    assert end.velocities[0, 0, 0] == pytest.approx(left, rel=1e-12, abs=1e-14)
    assert speed(end.velocities[0, 1]) == pytest.approx(math.hypot(normal, tangential), rel=1e-12)
    turn = 2.5 * tangential / R
    assert np.abs(end.angular_velocities[0, 1:, 2]) == pytest.approx(turn, rel=1e-12)
    energy = result.energy([0.0, scene.t_max]).total
    assert energy[1] < energy[0]


def velocities_after(**physics) -> np.ndarray:
    """Return the velocities after a collision with two touching balls, over the velocity before."""
    scene = scene_of(
        ball((-0.25, 0.0), (1.0, 0.0)), *PAIR, **{"rolling_friction": 0.0, "t_max": 1.0, **physics}
    )
    result = simulate(scene, record="events")
    return state_at(result, times_of(result, BALL_BALL)[1]).velocities[:, :2]


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_a_collision_with_two_touching_balls_is_as_published(e):
    """In another engine, with sequential impacts, the two balls leave at 1.65 and 0.83 m/s."""
    cue, *struck = velocities_after(ball_restitution=e, motion="sliding")
    assert cue == pytest.approx([(2 - 3 * e) / 5, 0.0], abs=1e-13)
    for velocity, side in zip(struck, (1, -1), strict=True):
        each = ROOT3 / 5 * (1 + e)
        assert velocity == pytest.approx([each * ROOT3 / 2, side * each / 2], abs=1e-13)


def test_one_impact_after_the_other_takes_sides_as_published():
    cue, *struck = velocities_after(impacts="sequential", motion="sliding")
    first, second = sorted(struck, key=speed, reverse=True)
    side = math.copysign(1.0, first[1])  # which of the two is hit first is not published
    r = ROOT3 / 8
    assert cue == pytest.approx([-1 / 8, -side * r], abs=1e-13)
    assert first == pytest.approx([3 / 4, side * 2 * r], abs=1e-13)
    assert second == pytest.approx([3 / 8, -side * r], abs=1e-13)


@pytest.mark.parametrize("impacts", ["simultaneous", "sequential"])
def test_a_cradle_hands_on_the_whole_velocity(impacts):
    """Fails if sequential impacts at one time share the velocity, as simultaneous ones would."""
    line = [ball((0.0, 0.0)), ball((2 * R, 0.0))]
    scene = scene_of(
        ball((-2 * R, 0.0), (1.0, 0.0)), *line, impacts=impacts, rolling_friction=0.0, t_max=1.0
    )
    result = simulate(scene, record="events")
    after = state_at(result, times_of(result, BALL_BALL)[1]).velocities[:, 0]
    assert after == pytest.approx([0.0, 0.0, 1.0], abs=4 * EPS)


@every_physics
def test_without_a_tie_simultaneous_and_sequential_are_the_same_bits(physics):
    # The gaps have different widths, so no two impacts are simultaneous.
    balls = [ball((-0.3, 0.01), (3.0, 0.0))]
    balls += [
        ball((0.1 + 0.07 * i + 0.003 * j, 0.066 * j + 0.002 * i))
        for i in range(3)
        for j in range(-1, 2)
    ]
    runs = [
        simulate(scene_of(*balls, impacts=impacts, **physics), record="events")
        for impacts in ("simultaneous", "sequential")
    ]
    assert len(collisions(runs[0])) > 5
    assert fingerprint(runs[0]) == fingerprint(runs[1])


@every_physics
def test_a_ball_that_rolled_before_it_meets_two_collides_with_the_spin_of_the_moment(physics):
    """Fails if the spin at the end of its last slide is used."""
    there, physics = 1.0, {**physics, "motion": "sliding"}
    pair = [ball((there + ROOT3 * R, R)), ball((there + ROOT3 * R, -R))]
    far = scene_of(
        ball((0.0, 0.0), (2.0, 0.0), angular_velocity=(0.0, -100.0, 0.0)), *pair, **physics
    )
    result = simulate(far, record="events")
    t = times_of(result, BALL_BALL)[0]
    before, after = state_before(result, t), state_at(result, t)
    near = ball(
        before.positions[0, :2],
        before.velocities[0, :2],
        angular_velocity=before.angular_velocities[0],
    )
    at_once = state_at(simulate(scene_of(near, *pair, **physics), record="events"), EPS)
    assert after.velocities == pytest.approx(at_once.velocities, abs=1e-12)
    assert after.angular_velocities == pytest.approx(at_once.angular_velocities, abs=1e-10)
