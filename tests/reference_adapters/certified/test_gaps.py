"""The search of gaps in doubles is a filter that doesn't change results."""

from __future__ import annotations

import math

import pytest
from proofs import SHOTS, jump, keys, overlap

from ghostball.reference_adapters.certified import (
    certify,
    gaps,
)


@pytest.mark.parametrize("scene", [*SHOTS.values(), *map(jump, (0, 3, 5))])
def test_a_search_in_doubles_changes_nothing(scene, monkeypatch):
    fast = certify(scene, cached=False)
    # With an infinite margin, every gap is searched in intervals.
    monkeypatch.setattr(gaps, "DOUBLES_ERROR", math.inf)
    thorough = certify(scene, cached=False)
    assert keys(fast) == keys(thorough)
    assert all(
        overlap(one.t, other.t) for one, other in zip(fast.events, thorough.events, strict=True)
    )
