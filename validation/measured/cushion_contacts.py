"""The speed ratio of cushion contacts, computed in the same way for real and simulated tracks.

A ball that leaves a cushion slides before it rolls, and trackers don't see the contact itself. The
speed is therefore taken from straight lines through the positions well before and well after the
contact. A model is evaluated in the same windows as the measurement, so both include the slide.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ghostball.validation.measured.tracks import Surface, Track, dips


@dataclass(frozen=True)
class Windows:
    """Time windows and criteria of free contacts; times [s] from the contact, lengths [m]."""

    before: tuple[float, float] = (-0.40, -0.02)
    after: tuple[float, float] = (0.40, 0.75)
    alone: tuple[float, float] = (-0.40, 0.80)
    """The time without contacts with other balls or cushions."""
    samples: int = 6
    """Smallest number of samples for each line."""
    covered: float = 0.6
    """Smallest part of a window that its samples must cover; if a tracker omits resting balls, a
    smaller part means that the ball rolls for too short a time."""
    gap: float = 0.2
    """Longest time without a sample."""
    straight: float = 0.004
    """Largest rms deviation of samples from their line, over both coordinates: a sliding ball has
    a larger one."""
    near: float = 0.012
    """Largest distance from the cushion in the nearest sample of a contact."""
    passing: float = 0.05
    """The same limit for other contacts: a fast ball may turn between two samples."""
    ball_margin: float = 0.03
    """Gap between two balls below which they may have touched."""
    slowest: float = 0.15
    """Lowest speed towards the cushion before the contact [m/s]."""


@dataclass(frozen=True)
class CushionContact:
    """One free contact with a cushion."""

    ball: str
    time: float  # of the nearest sample [s]
    axis: int  # 0: a cushion across x, 1: across y
    speed_before: float  # towards the cushion [m/s]
    speed_after: float  # away from it [m/s]

    @property
    def normal_ratio(self) -> float:
        """Ratio of the normal speeds after and before the contact, with the slide that follows."""
        return self.speed_after / self.speed_before


def cushion_contacts(
    balls: Mapping[str, Track], surface: Surface, windows: Windows | None = None
) -> list[CushionContact]:
    """Return the free cushion contacts of one shot, ball by ball."""
    windows = windows or Windows()
    found = []
    for name, track in balls.items():
        others = [other for ball, other in balls.items() if ball != name]
        turns = list(_turning_points(track, surface, windows.passing))
        for k, side in turns:
            time = float(track.times[k])
            first, last = (time + edge for edge in windows.alone)
            passed = [other for other in turns if first < track.times[other[0]] < last]
            near = surface.gaps(track.positions[k])[side] <= windows.near
            if not near or len(passed) > 1 or _meets(track, others, first, last, surface, windows):
                continue
            before = _line(track, windows.before, time, windows)
            after = _line(track, windows.after, time, windows)
            if before is None or after is None:
                continue
            axis = side // 2
            contact = CushionContact(name, time, axis, abs(before[axis]), abs(after[axis]))
            if contact.speed_before >= windows.slowest:
                found.append(contact)
    return found


def _turning_points(track: Track, surface: Surface, near: float) -> Iterator[tuple[int, int]]:
    """Yield the sample nearest to each contact with a cushion, and the side (`gaps`)."""
    for k, side in np.argwhere(dips(surface.gaps(track.positions), near)).tolist():
        yield k + 1, side


def _meets(
    track: Track, others: list[Track], first: float, last: float, surface: Surface, windows: Windows
) -> bool:
    """Return True if the ball may touch another one from `first` to `last`, or is unseen."""
    seen = track.between(first, last)
    if np.max(np.diff(seen.times), initial=0.0) > windows.gap:
        return True
    reach = 2.0 * surface.radius + windows.ball_margin
    apart = (np.linalg.norm(other.at(seen.times) - seen.positions, axis=1) for other in others)
    return any(np.min(one) < reach for one in apart)


def _line(
    track: Track, window: tuple[float, float], time: float, windows: Windows
) -> tuple[float, float] | None:
    """Return the velocity of a straight line through a window [m/s]; None if it isn't straight."""
    since = track.times - time
    if since[0] > window[0] or since[-1] < window[1]:
        return None
    inside = (since >= window[0]) & (since <= window[1])
    since, places = since[inside], track.positions[inside]
    if len(since) < windows.samples:
        return None
    if since[-1] - since[0] < windows.covered * (window[1] - window[0]):
        return None
    line = np.polynomial.polynomial.polyfit(since, places, 1)
    off = places - np.polynomial.polynomial.polyval(since, line).T
    if np.sqrt(np.mean(off**2)) > windows.straight:
        return None
    return float(line[1, 0]), float(line[1, 1])
