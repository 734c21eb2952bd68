"""Invalid limits of a proof."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from ghostball.reference_adapters.certified import CertifiedSettings


@pytest.mark.parametrize(
    "settings",
    [
        {"max_precision": 0},
        {"start_precision": 8},
        {"max_events": 0},
        {"width": 0.0},
        {"time_limit": float("inf")},
        {"digits": 50},
    ],
)
def test_wrong_settings_are_refused(settings):
    with pytest.raises(ValidationError):
        CertifiedSettings(**settings)
