"""What a cushion leaves of the speed towards it: one operator, for real tracks and an engine's.

A ball that leaves a cushion slides before it rolls, and no tracker sees the contact itself. So the
speed is taken from straight lines through the positions well before and well after, and a model
goes through the same windows as the measurement did: the slide is in both.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ghostball.validation.measured.tracks import Surface, Track, dips


@dataclass(frozen=True)
class Windows:
    """When the operator looks and which contacts count; times [s] from the contact, lengths [m]."""

    before: tuple[float, float] = (-0.40, -0.02)
    after: tuple[float, float] = (0.40, 0.75)
    alone: tuple[float, float] = (-0.40, 0.80)
    """When it touches no other ball and no other cushion."""
    samples: int = 6
    """The least number of samples of each line."""
    covered: float = 0.6
    """The least part of a window between its first and last sample; a ball that a tracker leaves
    out while it rests rolls for too short a time where that is less."""
    gap: float = 0.2
    """The longest time without a sample."""
    straight: float = 0.004
    """The most that samples may be off their line, the root mean square of both coordinates: a ball
    that slides is more."""
    near: float = 0.012
    """How near to the cushion the nearest sample of a contact must be."""
    passing: float = 0.05
    """The same, for it to be another contact: a fast ball may turn between two samples."""
    ball_margin: float = 0.03
    """The gap between two balls up to which they may have touched."""
    slowest: float = 0.15
    """The least speed towards the cushion before [m/s]."""


@dataclass(frozen=True)
class CushionContact:
    """One free contact."""

    ball: str
    time: float  # of the sample nearest to it [s]
    axis: int  # 0: a cushion across x, 1: across y
    speed_before: float  # towards the cushion [m/s]
    speed_after: float  # away from it [m/s]

    @property
    def normal_ratio(self) -> float:
        """What the cushion, and the slide that follows, leave of the speed towards it."""
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
    """Yield the sample nearest to each contact with a cushion, and the side as `gaps` has it."""
    for k, side in np.argwhere(dips(surface.gaps(track.positions), near)).tolist():
        yield k + 1, side


def _meets(
    track: Track, others: list[Track], first: float, last: float, surface: Surface, windows: Windows
) -> bool:
    """Whether the ball may meet another one from `first` to `last`, or it isn't known."""
    seen = track.between(first, last)
    if np.max(np.diff(seen.times), initial=0.0) > windows.gap:
        return True
    reach = 2.0 * surface.radius + windows.ball_margin
    apart = (np.linalg.norm(other.at(seen.times) - seen.positions, axis=1) for other in others)
    return any(np.min(one) < reach for one in apart)


def _line(
    track: Track, window: tuple[float, float], time: float, windows: Windows
) -> tuple[float, float] | None:
    """Return the velocity of a straight line through a window [m/s]; None: it isn't one."""
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
