"""The operator of cushion contacts: known rebounds are found again, and what isn't free is not."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.validation.measured.cushion_contacts import cushion_contacts
from ghostball.validation.measured.tracks import Surface, Track

SURFACE = Surface(2.84, 1.42, 0.03075)
TIMES = np.arange(0.0, 3.0, 0.02)


def rebound(ratio: float, at: float = 1.0, noise: float = 0.0) -> Track:
    """Return a ball that comes straight to the right cushion at 0.8 m/s, along it at 0.3 m/s."""
    since = TIMES - at
    away = np.where(since < 0.0, -0.8 * since, 0.8 * ratio * since)
    x = SURFACE.length - SURFACE.radius - away
    positions = np.column_stack([x, 0.3 + 0.3 * TIMES])
    return Track(TIMES, positions + np.random.default_rng(3).normal(0.0, noise, positions.shape))


def test_a_rebound_is_found_with_its_ratio():
    (contact,) = cushion_contacts({"cue": rebound(0.55)}, SURFACE)
    assert (contact.ball, contact.axis) == ("cue", 0)
    assert contact.time == pytest.approx(1.0)
    assert contact.normal_ratio == pytest.approx(0.55, rel=1e-12)
    assert contact.speed_before == pytest.approx(0.8)


def test_noise_of_a_tracker_moves_it_by_less_than_a_percent():
    (contact,) = cushion_contacts({"cue": rebound(0.55, noise=0.0004)}, SURFACE)
    assert contact.normal_ratio == pytest.approx(0.55, abs=0.005)


def test_what_begins_too_late_or_passes_a_ball_does_not_count():
    assert cushion_contacts({"cue": rebound(0.55, at=0.3)}, SURFACE) == []
    near = Track(TIMES, np.tile([2.6, 0.6 + 2.2 * SURFACE.radius], (len(TIMES), 1)))
    assert cushion_contacts({"cue": rebound(0.55), "other": near}, SURFACE) == []


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_ball_that_slides_before_or_after_does_not_count(sign):
    # Heated cloth takes 0.13 g from it, in whatever direction.
    track = rebound(0.55)
    since = np.maximum(sign * (TIMES - 1.0), 0.0)
    slides = track.positions + np.column_stack([0.0 * since, 0.5 * 0.13 * 9.81 * since**2])
    assert cushion_contacts({"cue": Track(TIMES, slides)}, SURFACE) == []


def test_samples_that_are_missing_or_cover_little_do_not_count():
    track = rebound(0.55)

    def without(first: float, last: float) -> Track:
        kept = (first > TIMES) | (last < TIMES)
        return Track(TIMES[kept], track.positions[kept])

    assert len(cushion_contacts({"cue": without(1.1, 1.25)}, SURFACE)) == 1
    assert cushion_contacts({"cue": without(1.1, 1.35)}, SURFACE) == []
    assert cushion_contacts({"cue": without(0.61, 0.79)}, SURFACE) == []
    assert cushion_contacts({"cue": without(0.9, 1.1)}, SURFACE) == []  # none near the cushion


def test_another_cushion_in_the_windows_does_not_count():
    track = rebound(0.55)
    y = SURFACE.radius + np.abs(0.3 * (TIMES - 1.3))
    corner = Track(TIMES, np.column_stack([track.positions[:, 0], y]))
    assert cushion_contacts({"cue": corner}, SURFACE) == []
