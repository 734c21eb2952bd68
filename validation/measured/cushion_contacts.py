"""What a cushion leaves of the speed towards it: one operator, for real tracks and an engine's.

A ball that leaves a cushion slides before it rolls, and no tracker sees the contact itself. So the
speed is taken from straight lines through the positions well before and well after, and a model
goes through the same windows as the measurement did: the slide is in both.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ghostball.validation.measured.tracks import FloatArray, Surface, Track


@dataclass(frozen=True)
class Windows:
    """When the operator looks and which contacts count; times [s] from the contact, lengths [m]."""

    before: tuple[float, float] = (-0.40, -0.02)
    after: tuple[float, float] = (0.40, 0.75)
    alone: tuple[float, float] = (-0.50, 0.80)
    """When it touches no other ball and no other cushion."""
    samples: int = 4
    """The least number of samples of each line."""
    straight: float = 0.004
    """How far a sample may be from its line, which a ball that slides isn't."""
    near: float = 0.015
    """How near to the cushion a turning point is a contact."""
    touching: float = 0.010
    """A gap below which balls, or a ball and a cushion, may have touched between samples."""
    slowest: tuple[float, float] = (0.45, 0.15)
    """The least speed before, and the least towards the cushion [m/s]."""


@dataclass(frozen=True)
class CushionContact:
    """One free contact: the velocities of both lines, along the cushion and away from it."""

    ball: str
    time: float  # [s]
    axis: int  # 0: a cushion across x, 1: across y
    speed_before: float  # towards the cushion [m/s]
    speed_after: float  # away from it [m/s]
    along_before: float  # along the cushion, in the direction of the motion before [m/s]
    along_after: float

    @property
    def normal_ratio(self) -> float:
        """What the cushion, and the slide that follows, leave of the speed towards it."""
        return self.speed_after / self.speed_before


def cushion_contacts(
    balls: Mapping[str, Track], surface: Surface, windows: Windows | None = None
) -> list[CushionContact]:
    """Return the free cushion contacts of one shot, ball by ball, in the order of time."""
    windows = windows or Windows()
    found = []
    for name, track in balls.items():
        others = [other for ball, other in balls.items() if ball != name]
        turns = list(_turning_points(track, surface, windows))
        for k, axis in turns:
            time = float(track.times[k])
            first, last = (time + edge for edge in windows.alone)
            if any(other != k and first <= track.times[other] <= last for other, _ in turns):
                continue
            if not _is_alone(track, others, surface, windows, time, axis):
                continue
            before = _line(track, windows.before, time, windows)
            after = _line(track, windows.after, time, windows)
            if before is None or after is None:
                continue
            contact = _contact(name, time, axis, before, after)
            speed = float(np.hypot(*before))
            if speed >= windows.slowest[0] and contact.speed_before >= windows.slowest[1]:
                found.append(contact)
    return found


def _gaps(track: Track, surface: Surface, axis: int) -> tuple[FloatArray, FloatArray]:
    """Return the gaps to both cushions across an axis, (n,) each [m]."""
    extent = (surface.length, surface.width)[axis]
    place = track.positions[:, axis]
    return place - surface.radius, extent - surface.radius - place


def _turning_points(track: Track, surface: Surface, windows: Windows) -> Iterator[tuple[int, int]]:
    """Yield the sample nearest to each contact with a cushion, and the axis across it."""
    for axis in (0, 1):
        for gap in _gaps(track, surface, axis):
            inner = gap[1:-1]
            least = (inner < windows.near) & (inner <= gap[:-2]) & (inner < gap[2:])
            yield from ((int(k), axis) for k in np.flatnonzero(least) + 1)


def _is_alone(
    track: Track,
    others: list[Track],
    surface: Surface,
    windows: Windows,
    time: float,
    axis: int,
) -> bool:
    """Whether the ball meets nothing but this cushion while the operator looks."""
    first, last = (time + edge for edge in windows.alone)
    if track.times[0] > first or track.times[-1] < time + windows.after[1]:
        return False
    times = np.arange(first, last, 0.01)
    place = track.at(times)
    for other in others:
        distances = np.linalg.norm(other.at(times) - place, axis=1)
        if np.min(distances) < 2.0 * surface.radius + windows.touching:
            return False
    seen = (track.times >= first) & (track.times <= last)
    return all(np.min(gap[seen]) > windows.touching for gap in _gaps(track, surface, 1 - axis))


def _line(
    track: Track, window: tuple[float, float], time: float, windows: Windows
) -> FloatArray | None:
    """Return the velocity of a straight line through a window, (2,) [m/s]; None: it isn't one."""
    since = track.times - time
    inside = (since >= window[0]) & (since <= window[1])
    if np.count_nonzero(inside) < windows.samples:
        return None
    terms = np.column_stack([np.ones(np.count_nonzero(inside)), since[inside]])
    fitted, *_ = np.linalg.lstsq(terms, track.positions[inside], rcond=None)
    off = np.linalg.norm(track.positions[inside] - terms @ fitted, axis=1)
    velocity: FloatArray = fitted[1]
    return velocity if np.max(off) <= windows.straight else None


def _contact(
    ball: str, time: float, axis: int, before: FloatArray, after: FloatArray
) -> CushionContact:
    along = 1.0 if before[1 - axis] >= 0.0 else -1.0
    return CushionContact(
        ball=ball,
        time=time,
        axis=axis,
        speed_before=abs(float(before[axis])),
        speed_after=abs(float(after[axis])),
        along_before=along * float(before[1 - axis]),
        along_after=along * float(after[1 - axis]),
    )
