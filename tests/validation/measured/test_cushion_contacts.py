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
    assert (contact.speed_before, contact.along_before) == pytest.approx((0.8, 0.3))


def test_noise_of_a_tracker_moves_it_by_less_than_a_percent():
    (contact,) = cushion_contacts({"cue": rebound(0.55, noise=0.0004)}, SURFACE)
    assert contact.normal_ratio == pytest.approx(0.55, abs=0.005)


def test_what_begins_too_late_or_passes_a_ball_does_not_count():
    assert cushion_contacts({"cue": rebound(0.55, at=0.3)}, SURFACE) == []
    near = Track(TIMES, np.tile([2.6, 0.6 + 2.2 * SURFACE.radius], (len(TIMES), 1)))
    assert cushion_contacts({"cue": rebound(0.55), "other": near}, SURFACE) == []


def test_a_line_that_bends_does_not_count():
    track = rebound(0.55)
    bent = track.positions.copy()
    bent[:, 1] += 0.5 * 0.8 * (TIMES - 1.0) ** 2
    assert cushion_contacts({"cue": Track(TIMES, bent)}, SURFACE) == []
