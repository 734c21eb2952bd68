"""Curves through samples, the noise of a tracker, and repeated samples."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.validation.measured.fit.curves import Curve, noise_of, without_stale
from ghostball.validation.measured.tracks import Track

TIMES = np.arange(0.0, 2.0, 0.02)


def rolls(noise: float = 0.0, seed: int = 1) -> Track:
    x = 0.2 + 0.8 * TIMES - 0.05 * TIMES**2
    positions = np.column_stack([x, 0.5 + 0.1 * TIMES])
    return Track(TIMES, positions + np.random.default_rng(seed).normal(0.0, noise, positions.shape))


def test_a_parabola_is_found_again_from_the_middle_on():
    track = rolls()
    curve = Curve.through(track.times, 2)
    place, velocity, half = curve.of(track.positions)
    assert curve.middle == pytest.approx(0.99)
    assert place == pytest.approx([0.2 + 0.8 * 0.99 - 0.05 * 0.99**2, 0.5 + 0.1 * 0.99])
    assert velocity == pytest.approx([0.8 - 0.1 * 0.99, 0.1])
    assert half == pytest.approx([-0.05, 0.0], abs=1e-12)
    assert curve.off(track.positions) == pytest.approx(0.0, abs=1e-12)


def test_the_covariance_is_that_of_many_noisy_tracks():
    curve = Curve.through(TIMES, 1)
    found = [curve.of(rolls(1e-3, seed).positions)[1, 0] for seed in range(400)]
    assert np.std(found) == pytest.approx(1e-3 * np.sqrt(curve.covariance[1, 1]), rel=0.15)


@pytest.mark.parametrize("noise", [4e-4, 2e-3])
def test_the_noise_of_a_tracker_is_found(noise):
    assert noise_of([rolls(noise), rolls(noise, 2)]) == pytest.approx(noise, rel=0.15)


def test_balls_at_rest_and_short_tracks_say_nothing_of_noise():
    still = Track(TIMES, np.full((len(TIMES), 2), 0.5))
    assert noise_of([still, Track(TIMES[:2], still.positions[:2])]) == 0.0


def test_samples_that_repeat_while_the_ball_moves_are_left_out():
    track = rolls()
    positions = track.positions.copy()
    positions[[10, 40, 41]] = positions[[9, 39, 39]]
    fresh = without_stale(Track(TIMES, positions))
    assert len(fresh.times) == len(TIMES) - 3
    assert fresh.positions == pytest.approx(np.delete(track.positions, [10, 40, 41], axis=0))


def test_samples_of_a_ball_at_rest_are_kept():
    still = Track(TIMES, np.full((len(TIMES), 2), 0.5))
    assert len(without_stale(still).times) == len(TIMES)


def test_a_window_has_the_samples_between():
    part = rolls().between(0.5, 0.6)
    assert part.times == pytest.approx([0.5, 0.52, 0.54, 0.56, 0.58, 0.6])
