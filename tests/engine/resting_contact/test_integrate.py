"""Tests of the motion of balls in contact, integrated as far as gaps permit, also in air."""

from __future__ import annotations

import numpy as np
from islands import pushing_pair
from kernels import interpreted

from ghostball.engine import simulate
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.resting_contact import integrate
from ghostball.model import Ball, Physics, Scene
from ghostball.model.rounding import CONTACT_TOLERANCE


def test_a_motion_that_is_followed_in_air_keeps_its_gap():
    """A piece once kept the powers of the motion of a single ball: an overlap of 1.2e-12 m."""
    scene = Scene(
        name="together",
        physics=Physics(
            preset="pool", ball_restitution=0.0, rolling_friction_quadratic=0.02597680031458461
        ),
        balls=[
            Ball(
                id="b1",
                position=(2.502314150979903, 1.1376138277456158),
                radius=0.037685849020096945,
            ),
            Ball(
                id="b0",
                position=(2.5062021953318694, 1.0662359890578577),
                velocity=(-0.019331868098263722, 0.3549000056938646),
                radius=0.03379780466813081,
            ),
        ],
    )
    result = simulate(scene, record="events")
    assert result.work["contact_pieces"] > 0
    segments = result.trajectory.segments
    ends = np.unique(np.concatenate([segments[0][:, 0], segments[1][:, 0]]))
    times = (ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0.0, 1.0, 9)).ravel()
    between = np.diff(result.sample(times).positions[:, :, :2], axis=1)[:, 0]
    reach = float(np.sum(scene.radii))
    largest_overlap = reach - np.min(np.hypot(*between.T))
    assert largest_overlap <= CONTACT_TOLERANCE * reach + 8.0 * EPS * 3.0


@interpreted  # compiled kernels can't be observed
def test_removing_remaining_rates_conserves_momentum(monkeypatch):
    """With wrong shares, the shot ends only 1e-14 m away, so each step's momentum is checked."""
    masses, end_rates, taken, drifts = np.array([0.2, 0.05]), integrate._end_rates, [], []

    def watched(world, count, gaps):
        stage = world.contacts.stage
        order = [int(world.contacts.motion[k].index) for k in range(2)]
        before = np.array([(stage[m].vx, stage[m].vy) for m in order])
        end_rates(world, count, gaps)
        after = np.array([(stage[m].vx, stage[m].vy) for m in order])
        taken.append(np.abs(after - before).max())
        drifts.append(np.abs(masses @ (after - before)).max())

    monkeypatch.setattr(integrate, "_end_rates", watched)
    simulate(pushing_pair((0.03, 0.02), masses))
    assert max(taken) > 1e-13
    assert max(drifts) <= 4.0 * EPS * 0.2 * 0.3
