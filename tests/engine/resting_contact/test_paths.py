"""Tests of the pieces along a path, whose number is limited."""

from __future__ import annotations

import pytest
from islands import kept_shot, largest_overlap

from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.resting_contact import paths


@pytest.mark.skipif(COMPILED, reason="compiled kernels can't be replaced")
def test_a_motion_of_too_many_pieces_is_followed_less_far(monkeypatch):
    """Fails if the motion gets fewer pieces than its gaps need."""
    far = kept_shot("squeezed-pair")
    monkeypatch.setattr(paths, "_MOST_PIECES", 4)
    near = kept_shot("squeezed-pair")
    assert near.work["contact_steps"] > far.work["contact_steps"]
    assert largest_overlap(near) <= 1e-12
    assert near.rest_positions == pytest.approx(far.rest_positions, rel=0.0, abs=1e-7)
