"""Tests of the tangent map: its arguments, and the predictability horizon."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from changes import recorded

from ghostball.engine import simulate
from ghostball.engine.sensitivity import QUALITY, ROUNDING, tangent_of
from ghostball.model import EventKind, GhostballError
from ghostball.validation.scenes.library import find_scene

TWO = np.ones((1, 2, 7))
"""A change of two balls."""


def test_a_recorded_motion_must_be_that_of_the_scene():
    one, two = recorded(find_scene("stop")), recorded(find_scene("half-ball-cut"))
    with pytest.raises(GhostballError, match="must be those of the scene, which has 2 balls"):
        tangent_of(two.scene, one.trajectory, one.events, np.ones((1, 2, 7)))
    events = two.events.copy()
    events["a"][0] = 99
    with pytest.raises(GhostballError, match="99"):
        tangent_of(two.scene, two.trajectory, events, np.ones((1, 2, 7)))


def test_events_at_obstacles_must_be_of_the_scene():
    with_table = recorded(find_scene("wall-bounce"))
    assert EventKind.BALL_CUSHION in with_table.events["kind"]
    free = with_table.scene.model_copy(update={"table": None})
    one = np.ones((1, len(free.balls), 7))
    with pytest.raises(GhostballError, match=r"whose obstacles are \[\], got events at obstacles"):
        tangent_of(free, with_table.trajectory, with_table.events, one)
    events = with_table.events.copy()
    events["b"][events["kind"] == EventKind.BALL_CUSHION] = 7
    with pytest.raises(GhostballError, match=r"obstacles are \[0, 1, 2, 3\], got .* \[7\]"):
        tangent_of(with_table.scene, with_table.trajectory, events, one)


def test_a_trajectory_must_be_of_the_scene():
    """A trajectory in air has more columns, and a ball without segments would use another's."""
    air, shot = recorded(find_scene("air-rolls")), recorded(find_scene("half-ball-cut"))
    plain = air.scene.physics.model_copy(
        update={"air_drag": 0.0, "rolling_friction_quadratic": 0.0}
    )
    scene = air.scene.model_copy(update={"physics": plain})
    one = np.ones((1, len(scene.balls), 7))
    with pytest.raises(GhostballError, match="with 14 numbers for each segment"):
        tangent_of(scene, air.trajectory, air.events, one)
    empty = replace(shot.trajectory, segments=(shot.trajectory.segments[0], np.empty((0, 14))))
    with pytest.raises(GhostballError, match=r"got arrays of shapes \[\(0, 14\)"):
        tangent_of(shot.scene, empty, shot.events, TWO)


def test_horizon_is_where_the_error_passes_the_tolerance():
    result = recorded(find_scene("chaos-a"))
    horizon = result.horizon(tolerance=1e-3)
    assert 0.0 < horizon < result.rest_time

    def error(t):
        return QUALITY * ROUNDING * np.max(result.sensitivity(t))

    assert error(horizon) >= 1e-3 >= error(horizon * (1 - 1e-12))
    assert result.horizon(tolerance=1e-6) < horizon < result.horizon(tolerance=1.0)
    assert result.horizon(error=1e-9) < horizon
    assert result.horizon(tolerance=1e12) == math.inf


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan, math.inf])
def test_a_tolerance_must_be_a_positive_number(tolerance):
    with pytest.raises(GhostballError, match="`tolerance` must be a positive number"):
        recorded(find_scene("stop")).horizon(tolerance)


@pytest.mark.parametrize(
    ("directions", "message"),
    [
        (np.zeros((1, 2, 7)), r"shape \(m, 1, 7\)"),
        (np.zeros((0, 1, 7)), "m at least 1"),
        (np.zeros(7), r"got \(7,\)"),
        (np.full((1, 1, 7), np.nan), "must be finite"),
    ],
)
def test_directions_are_checked(directions, message):
    with pytest.raises(GhostballError, match=message):
        recorded(find_scene("stop")).tangent(directions)


def test_a_run_that_recorded_nothing_has_no_sensitivity():
    with pytest.raises(GhostballError, match='record="trajectory"'):
        simulate(find_scene("stop")).sensitivity(1.0)


def test_an_engine_that_records_frames_has_no_sensitivity():
    from ghostball.reference_adapters import make_engine

    result = make_engine("paper-discrete").simulate(find_scene("stop"), record="trajectory")
    with pytest.raises(GhostballError, match="records frames"):
        result.horizon()
