"""Events that a model simulates: each starts from the given values, in the windows of the data."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import EventKind, Physics
from ghostball.validation.measured.fit.curves import Curve
from ghostball.validation.measured.fit.event_simulation import scene_of, seen_in
from ghostball.validation.measured.fit.events import (
    CushionEvent,
    HitEvent,
    RollingEvent,
    slowing_of,
)

POOL = Physics(preset="pool", spinning_friction_rate=10.0)
RADIUS = 0.028575
BEFORE = np.arange(0.0, 0.29, 0.02)


def unweighed(kind, given, seen, times, *curves):
    """Return an event without measurement errors."""
    none = np.zeros((0, 0))
    return kind("1", 0.8, RADIUS, given, none, seen, none, times, *curves)


def played(event, given):
    both = [(event, given), (event, given)]  # both lanes get the same event
    result = simulate(scene_of(POOL, both), record="trajectory")
    seen, beside = seen_in(result, both)
    assert beside == pytest.approx(seen, abs=1e-9)
    return result, seen


def test_a_rolling_ball_has_its_speed_in_the_middle_and_slows_by_its_friction():
    curve = Curve.through(np.arange(0.0, 1.0, 0.02), 2)
    x = 0.6 * (curve.times - curve.middle) - 0.05 * (curve.times - curve.middle) ** 2
    assert slowing_of(curve.of(np.column_stack([x, 0.0 * x]))) == pytest.approx((0.6, 0.1))
    event = unweighed(RollingEvent, np.array([0.6]), np.array([0.1]), curve.times, curve)
    result, (slowing,) = played(event, event.given)
    speed = np.linalg.norm(result.sample([curve.middle]).velocities[0, 0])
    assert speed == pytest.approx(0.6)
    assert slowing == pytest.approx(0.01 * 9.81)


@pytest.mark.parametrize("side", [0.3, 0.0, -0.2])
def test_a_ball_meets_a_cushion_with_the_velocity_and_the_side_that_are_given(side):
    after = Curve.through(np.arange(0.7, 1.0, 0.02), 1)
    given = np.array([0.8, 0.2, side])
    before = Curve.through(BEFORE, 1)
    event = unweighed(CushionEvent, given, np.zeros(2), after.times, before, after, 0.25)
    result, seen = played(event, given)
    impact, _ = result.events["t"][result.events["kind"] == EventKind.BALL_CUSHION]
    middle = result.sample([before.middle]).velocities[0, 0]
    assert middle[:2] == pytest.approx(given[:2])
    spin = result.sample([impact - 1e-9]).angular_velocities[0, 0, 2]
    assert spin * RADIUS == pytest.approx(side * np.linalg.norm(given[:2]), abs=5e-3)
    assert 0.3 < seen[0] < 0.5


def test_a_hit_begins_where_the_mean_of_the_samples_is():
    before = Curve.through(BEFORE, 1)
    after = Curve.through(np.arange(0.6, 0.85, 0.02), 1)
    given = np.array([-0.2, 0.01, 0.8, 0.0, 0.0])
    event = unweighed(HitEvent, given, np.zeros(8), after.times, before, (after, after))
    result, seen = played(event, event.given)
    places = result.sample(BEFORE).positions[:, 0, :2] - result.scene.positions[1, :2]
    assert places.mean(axis=0) == pytest.approx(given[:2])
    assert result.collision_counts["ball-ball"] == 2
    # Apart from the cloth, one ball gains the velocity that the other loses: both move on.
    struck, hit = seen[2:4], seen[6:8]
    assert 0.0 < struck[0] < hit[0] < 0.8
