"""The deceleration of rolling balls, computed in the same way for real and simulated tracks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ghostball.model import Physics, Table
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.simulated_ball import (
    POOL_BALL,
    OperatorError,
    Play,
    rolling_deceleration,
    track_of,
)
from ghostball.validation.measured.tracks import Surface, Track


@dataclass(frozen=True)
class RollingWindows:
    """The criteria of free rolling; times [s], lengths [m]."""

    length: float = 1.0
    after: float = 0.6
    """Time after a contact, or the start, from which a ball rolls and no longer slides."""
    samples: int = 15
    """Smallest number of samples in a window; gaps between samples are at most `gap`."""
    gap: float = 0.2
    off: float = 0.004
    """Largest distance of a sample from the parabola through the window."""
    touching: float = 0.020
    """Gap to a ball or a cushion below which a contact between samples is possible."""
    slowest: float = 0.1
    """Lowest speed in the middle of a window [m/s]."""


@dataclass(frozen=True)
class Rolling:
    """A window in which a ball rolled freely."""

    ball: str
    time: float  # of the middle [s]
    speed: float  # at that time [m/s]
    deceleration: float  # [m/s^2]


def rolling_windows(
    balls: Mapping[str, Track], surface: Surface, windows: RollingWindows | None = None
) -> list[Rolling]:
    """Return the windows of one shot in which a ball rolled freely, ball by ball, in order.

    The windows follow each other without overlap; the first one starts `after` seconds after a
    contact of the ball.
    """
    windows = windows or RollingWindows()
    found = []
    for name, track in balls.items():
        others = [other for ball, other in balls.items() if ball != name]
        for first in _beginnings(track, others, surface, windows):
            rolled = _rolled(name, track, first, windows)
            if rolled is not None and rolled.speed >= windows.slowest:
                found.append(rolled)
    return found


def _beginnings(
    track: Track, others: list[Track], surface: Surface, windows: RollingWindows
) -> Iterator[float]:
    """Yield the starts of windows [s]."""
    met = track.times[surface.least_gaps(track, others) < windows.touching]
    edges = [track.times[0], *met, track.times[-1]]
    for begin, end in pairwise(edges):
        count = int((end - begin - windows.after) / windows.length)
        yield from (begin + windows.after + k * windows.length for k in range(count))


def _rolled(name: str, track: Track, first: float, windows: RollingWindows) -> Rolling | None:
    """Return the result of a parabola through a window; None if it has few samples or a bad fit."""
    seen, middle = track.between(first, first + windows.length), first + windows.length / 2.0
    since: FloatArray = seen.times - middle
    if len(since) < windows.samples or np.max(np.diff(since)) > windows.gap:
        return None
    curve = np.polynomial.polynomial.polyfit(since, seen.positions, 2)
    off = seen.positions - np.polynomial.polynomial.polyval(since, curve).T
    if np.max(np.linalg.norm(off, axis=1)) > windows.off:
        return None
    _, velocity, half = curve
    speed = float(np.hypot(*velocity))
    if speed == 0.0:
        return None
    return Rolling(name, middle, speed, float(-2.0 * (half @ velocity) / speed))


_TABLE = Table(length=10.0, width=2.0)
_DURATION = 1.65  # [s]
_ANY_SPEED = RollingWindows(slowest=0.0)


def deceleration(play: Play, physics: Physics, speed: float) -> float:
    """Return the simulated deceleration of a rolling ball with a speed in mid-window [m/s^2].

    Raises `OperatorError` if it doesn't roll.
    """
    before = _ANY_SPEED.after + _ANY_SPEED.length / 2.0
    start = speed + rolling_deceleration(physics, speed) * before
    track = track_of(
        play,
        physics,
        _TABLE,
        POOL_BALL,
        position=(1.0, 1.0),
        velocity=(start, 0.0),
        lasts=_DURATION,
    )
    surface = Surface(_TABLE.length, _TABLE.width, POOL_BALL.radius)
    found = rolling_windows({"cue": track}, surface, _ANY_SPEED)
    if not found:
        raise OperatorError(f"a ball that started to roll at {start:.3g} m/s did not roll")
    return found[0].deceleration
