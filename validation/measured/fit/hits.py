"""Clean hits in tracks: a ball that rolls meets one at rest, and nothing else is near."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.cushion_contacts import Windows
from ghostball.validation.measured.fit.alone import has_rolled, is_free
from ghostball.validation.measured.fit.events import Event, HitEvent
from ghostball.validation.measured.fit.lines import Curve, window
from ghostball.validation.measured.tracks import Surface, Track, dips

BEFORE, AFTER = (-0.30, -0.02), (0.30, 0.55)
"""Where straight lines are laid through the places of the balls [s], from when they meet."""
_ALONE = 0.56
"""How long after it both balls must meet nothing [s]."""
_GLANCING = 0.85
"""The largest offset from a full hit, in diameters: beyond it, noise decides whether they meet."""
_MEETING = 0.10
"""The gap of two balls in the samples nearest to their meeting, at most [m]: they may be fast."""
_AGREE = 0.06
"""How far the nearest samples may be from when the line of a ball says that they meet [s]."""
_RESTING = 0.003
"""How far samples of a ball at rest may be from each other, but for noise [m]."""
_LEFT_OUT = 0.3
"""Time without a sample from which on a ball was left out since it rested [s]."""
_SAMPLES = 5
_MOST_RESTING = 25


def hits(shot: str, balls: Mapping[str, Track], surface: Surface, noise: float) -> Iterator[Event]:
    """Yield the clean hits of one shot; `noise` [m] of a coordinate of a sample."""
    for name, track in balls.items():
        for other, target in balls.items():
            if other == name:
                continue
            rest = [ball for key, ball in balls.items() if key not in (name, other)]
            for time in _meetings(track, target, surface):
                found = _Meeting(track, target, rest, surface, noise).event(shot, time)
                if found is not None:
                    yield found


def _meetings(track: Track, target: Track, surface: Surface) -> list[float]:
    """Return when two balls are nearest to each other, where they may meet [s]."""
    gaps = np.linalg.norm(target.at(track.times) - track.positions, axis=1)
    gaps -= 2.0 * surface.radius
    times: list[float] = track.times[1:-1][dips(gaps, _MEETING)].tolist()
    return times


class _Meeting:
    """A ball, and one that it may hit."""

    def __init__(
        self, track: Track, target: Track, rest: Sequence[Track], surface: Surface, noise: float
    ) -> None:
        self._track, self._target, self._rest = track, target, rest
        self._surface, self._noise = surface, noise

    def event(self, shot: str, near: float) -> Event | None:
        """Return the hit that is near a time [s]; None: there is none, or it isn't clean."""
        before = window(self._track, near + BEFORE[0], near + BEFORE[1])
        resting = self._resting(near + BEFORE[1])
        if len(before.times) < _SAMPLES or not len(resting):
            return None
        origin, place = before.times[0], np.mean(resting, axis=0)
        line = Curve.through(before.times - origin, 1)
        middle, velocity = line.of(before.positions)
        speed, (x, y) = float(np.linalg.norm(velocity)), velocity
        axes = np.array([[x, y], [-y, x]]) / max(speed, Windows.slowest)
        ahead, aside = axes @ (place - middle)
        reach = 2.0 * self._surface.radius
        if speed < Windows.slowest or abs(aside) > _GLANCING * reach:
            return None
        time = origin + line.middle + float(ahead - np.sqrt(reach**2 - aside**2)) / speed
        if abs(time - near) > _AGREE or time < before.times[-1]:
            return None
        if not self._is_clean(origin, time, speed):
            return None
        afters = [window(one, time + AFTER[0], time + AFTER[1]) for one in self._pair]
        if min(len(after.times) for after in afters) < _SAMPLES:
            return None
        if line.off(before.positions) > max(Windows.straight, 2.0 * self._noise):
            return None
        curves = [Curve.through(after.times - origin, 1) for after in afters]
        seen = [
            curve.of((after.positions - place) @ axes.T).ravel()
            for curve, after in zip(curves, afters, strict=True)
        ]
        return HitEvent.of(
            shot,
            (line, curves[0], curves[1]),
            np.array([-ahead, -aside, speed, 0.0]),
            np.concatenate(seen),
            len(resting),
            self._noise,
            self._surface.radius,
        )

    @property
    def _pair(self) -> tuple[Track, Track]:
        return self._track, self._target

    def _resting(self, until: float) -> FloatArray:
        """Return the last places (n, 2) of the other ball until a time, none if it may have moved.

        A tracker may leave a ball out while it rests.
        """
        times, places = self._target.times, self._target.positions
        seen = int(np.searchsorted(times, until, side="right"))
        places = places[max(seen - _MOST_RESTING, 0) : seen]
        if not len(places):
            return places
        apart = np.linalg.norm(places - places[-1], axis=1)
        moved = np.flatnonzero(apart > max(_RESTING, 5.0 * self._noise))
        places = places[moved[-1] + 1 if len(moved) else 0 :]
        left_out = until - times[seen - 1] > _LEFT_OUT
        return places if left_out or len(places) >= _SAMPLES else places[:0]

    def _is_clean(self, origin: float, time: float, speed: float) -> bool:
        """Whether the ball rolls from `origin` to the hit, and both meet nothing else after it."""
        others = [*self._rest, self._target]
        return (
            has_rolled(self._track, others, self._surface, origin, speed)
            and is_free(self._track, self._rest, self._surface, origin, time + _ALONE)
            and is_free(self._target, self._rest, self._surface, time, time + _ALONE)
        )
