"""Whether a ball met nothing for a while."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ghostball.validation.measured.cushion_contacts import Windows
from ghostball.validation.measured.fit.lines import window
from ghostball.validation.measured.tracks import Surface, Track

ROLLED = 0.7
"""How long a ball must have met nothing before a window, for each m/s of its speed in it [s^2/m].

One that came from a cushion slides for less where the friction of the cloth is at least 0.13; one
that was struck with much draw for longer.
"""


def has_rolled(
    track: Track, others: Sequence[Track], surface: Surface, time: float, speed: float
) -> bool:
    """Whether a ball of this speed has met nothing for so long before a time that it rolls."""
    return is_free(track, others, surface, time - ROLLED * speed, time)


def is_free(
    track: Track, others: Sequence[Track], surface: Surface, first: float, last: float
) -> bool:
    """Whether a ball meets nothing from `first` to `last`, and is seen all along."""
    if track.times[0] > first or track.times[-1] < last:
        return False
    seen = window(track, first, last)
    if np.max(np.diff([first, *seen.times, last])) > Windows.gap:
        return False
    return bool(np.min(surface.least_gaps(seen, others), initial=np.inf) > Windows.ball_margin)
