"""The operator of rolling finds known decelerations; the preset has the measured values."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.rolling import deceleration, rolling_windows
from ghostball.validation.measured.table_agreement import MeasuredEngine, families_of
from ghostball.validation.measured.tracks import Surface, Track, tracks_of

SURFACE = Surface(2.84, 1.42, 0.03075)
TIMES = np.arange(0.0, 3.0, 0.02)
PLAY = partial(simulate, record="trajectory")


def rolls(deceleration: float = 0.05, noise: float = 0.0) -> Track:
    x = 0.4 + 0.7 * TIMES - 0.5 * deceleration * TIMES**2
    positions = np.column_stack([x, np.full(len(TIMES), 0.7)])
    return Track(TIMES, positions + np.random.default_rng(5).normal(0.0, noise, positions.shape))


def test_a_known_deceleration_is_found_in_each_window():
    found = rolling_windows({"cue": rolls()}, SURFACE)
    assert [one.time for one in found] == pytest.approx([1.1, 2.1])
    assert [one.speed for one in found] == pytest.approx([0.645, 0.595])
    assert [one.deceleration for one in found] == pytest.approx([0.05, 0.05])


def test_noise_of_a_tracker_averages_out():
    found = [
        one.deceleration
        for seed in range(20)
        for one in rolling_windows({str(seed): rolls(0.05, noise=0.0004)}, SURFACE)
    ]
    assert np.mean(found) == pytest.approx(0.05, abs=0.003)


def test_a_ball_that_comes_near_ends_a_window():
    still = Track(TIMES, np.tile([0.4 + 0.7 * 1.5, 0.7 + 2.1 * SURFACE.radius], (len(TIMES), 1)))
    found = rolling_windows({"cue": rolls(), "still": still}, SURFACE)
    assert [one.ball for one in found] == []


def test_samples_that_are_missing_or_bend_make_no_window():
    track = rolls()
    kept = (TIMES < 1.0) | (TIMES > 1.3)
    (late,) = rolling_windows({"cue": Track(TIMES[kept], track.positions[kept])}, SURFACE)
    assert late.time == pytest.approx(2.1)
    bent = track.positions + np.column_stack([0.0 * TIMES, 0.01 * np.sin(9.0 * TIMES)])
    assert rolling_windows({"cue": Track(TIMES, bent)}, SURFACE) == []


def test_the_preset_carom_slows_balls_as_was_measured():
    for row in facts_of("rolling-carom").rows:
        start = row.at + 1.1 * row.value  # the first window is centred on this speed
        ball = Ball(id="cue", position=(1.0, 1.0), velocity=(start, 0.0), radius=0.03075)
        scene = Scene(name="rolls", balls=[ball], t_max=3.0, physics=Physics(preset="carom"))
        tracks = tracks_of(simulate(scene, record="trajectory"))
        first, *_ = rolling_windows(tracks, Surface(10.0, 2.0, 0.03075))
        assert first.speed == pytest.approx(row.at, abs=0.001)
        assert first.deceleration == pytest.approx(row.value, rel=0.01)


def test_our_engine_follows_what_cloth_does_at_each_speed():
    (family,) = families_of("rolling-pool", MeasuredEngine(make_engine("ghostball"), PLAY))
    assert family.most < 1.0
    assert family.settings["rolling_friction_quadratic"] > 0.0


def test_a_deceleration_is_that_of_the_cloth():
    physics = Physics(motion="sliding", rolling_friction=0.01, rolling_friction_quadratic=0.02)
    expected = 0.01 * 9.81 + 0.02 * 0.8**2
    assert deceleration(PLAY, physics, 0.8) == pytest.approx(expected, rel=1e-3)
