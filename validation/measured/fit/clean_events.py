"""Find the clean events in tracks: isolated motions, long after any other contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, permutations

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.cushion_contacts import CushionContact, Windows, cushion_contacts
from ghostball.validation.measured.fit.curves import Curve, noise_of, without_stale
from ghostball.validation.measured.fit.events import (
    SIDE,
    CushionEvent,
    FitEvent,
    HitEvent,
    RollingEvent,
    slowing_of,
)
from ghostball.validation.measured.rolling import RollingWindows, rolling_windows
from ghostball.validation.measured.tracks import Shots, Surface, Track, dips

CUSHION = Windows(before=(-0.30, -0.02), alone=(-0.30, 0.80), near=0.05, samples=5)
"""The windows of the published measurement, with two changes. The window before is shorter, so that
more balls have rolled for long enough. The distance in the nearest sample may be larger, for slow
cameras.
"""
ROLLING = RollingWindows(after=1.0)
_LEAST_NOISE = 1e-5
"""Least noise assumed for a track [m]: files contain rounded values."""
ROLLING_TIME = 0.7
"""Time without contacts required before a window, per m/s of speed in it [s^2/m].

A ball that left a cushion slides for less time if the friction of the cloth is at least 0.13; a
ball struck with much draw slides for longer.
"""

WINDOW_BEFORE, WINDOW_AFTER = (-0.30, -0.02), (0.30, 0.55)
"""Time windows of the straight lines before and after a hit [s], from the contact."""
_ISOLATION_TIME = 0.56
"""Time after a hit without other contacts of both balls [s]."""
_LARGEST_OFFSET = 0.85
"""Largest offset from a full hit, in diameters: beyond it, noise decides whether the balls touch.
"""
_CONTACT_GAP = 0.10
"""Largest gap of two balls in the samples nearest to their contact [m]; they may be fast."""
_TIME_DIFFERENCE = 0.06
"""Largest time between the nearest samples and the computed contact [s]."""
_REST_DISTANCE = 0.003
"""Largest distance between samples of a ball at rest, apart from noise [m]."""
_OMISSION_TIME = 0.3
"""Time without a sample after which a tracker has omitted a ball because it rests [s]."""
_SAMPLES = 5
_MOST_RESTING = 25


@dataclass(frozen=True)
class CleanEvents:
    """The clean events of a table's tracks, and the noise of a coordinate of a sample [m]."""

    rolling: Sequence[FitEvent]
    cushion: Sequence[FitEvent]
    hit: Sequence[FitEvent]
    noise: float

    @property
    def families(self) -> Mapping[str, Sequence[FitEvent]]:
        """The events by family."""
        return {"rolling": self.rolling, "cushion": self.cushion, "hit": self.hit}


def find_clean_events(shots: Shots, surface: Surface) -> CleanEvents:
    """Return the clean events of all shots."""
    fresh = {
        shot: {ball: without_stale(track) for ball, track in balls.items()}
        for shot, balls in shots.items()
    }
    noise = noise_of([track for balls in fresh.values() for track in balls.values()])
    every = [
        _TrackedShot(name, balls, surface, max(noise, _LEAST_NOISE))
        for name, balls in fresh.items()
    ]
    return CleanEvents(
        [*chain.from_iterable(shot.rolling() for shot in every)],
        [*chain.from_iterable(shot.cushions() for shot in every)],
        [*chain.from_iterable(shot.hits() for shot in every)],
        noise,
    )


def has_rolled(
    track: Track, others: Sequence[Track], surface: Surface, time: float, speed: float
) -> bool:
    """Return True if a ball with this speed has had no contact for long enough to roll."""
    return is_free(track, others, surface, time - ROLLING_TIME * speed, time)


def is_free(
    track: Track, others: Sequence[Track], surface: Surface, first: float, last: float
) -> bool:
    """Return True if a ball has no contact from `first` to `last`, and is tracked all the time."""
    if track.times[0] > first or track.times[-1] < last:
        return False
    seen = track.between(first, last)
    if np.max(np.diff([first, *seen.times, last])) > Windows.gap:
        return False
    return bool(np.min(surface.least_gaps(seen, others), initial=np.inf) > Windows.ball_margin)


@dataclass(frozen=True)
class _TrackedShot:
    """The tracks of one shot, and the noise of a coordinate of a sample [m]."""

    name: str
    balls: Mapping[str, Track]
    surface: Surface
    noise: float

    def _others(self, *names: str) -> list[Track]:
        return [track for name, track in self.balls.items() if name not in names]

    def rolling(self) -> Iterator[FitEvent]:
        """Yield the windows in which a ball rolls."""
        off, half = max(ROLLING.off, 5.0 * self.noise), ROLLING.length / 2.0
        for one in rolling_windows(self.balls, self.surface, replace(ROLLING, off=off)):
            samples = self.balls[one.ball].between(one.time - half, one.time + half)
            curve = Curve.through(samples.times - samples.times[0], 2)
            covariance = self.noise**2 * curve.covariance
            speed, slowing = slowing_of(curve.of(samples.positions))
            yield RollingEvent(
                self.name,
                speed,
                self.surface.radius,
                np.array([speed]),
                covariance[1:2, 1:2],
                np.array([slowing]),
                4.0 * covariance[2:3, 2:3],
                curve.times,
                curve,
            )

    def cushions(self) -> Iterator[FitEvent]:
        """Yield the free cushion contacts of balls that rolled to the cushion."""
        straight = max(CUSHION.straight, 2.0 * self.noise)
        for one in cushion_contacts(self.balls, self.surface, replace(CUSHION, straight=straight)):
            found = self._cushion(one)
            if found is not None:
                yield found

    def _cushion(self, one: CushionContact) -> FitEvent | None:
        track = self.balls[one.ball]
        parts = [
            track.between(one.time + first, one.time + last)
            for first, last in (CUSHION.before, CUSHION.after)
        ]
        origin = parts[0].times[0]
        before, after = (Curve.through(part.times - origin, 1) for part in parts)
        place, velocity = before.of(parts[0].positions)
        speed = float(np.linalg.norm(velocity))
        if not has_rolled(track, self._others(one.ball), self.surface, origin, speed):
            return None
        left = after.of(parts[1].positions)[1]
        towards = 1.0 if velocity[one.axis] > 0.0 else -1.0
        gaps = self.surface.gaps(place - before.middle * velocity)
        given = np.array([towards * velocity[one.axis], velocity[1 - one.axis], 0.0])
        variance = self.noise**2 * before.covariance[1, 1]
        return CushionEvent(
            self.name,
            float(np.linalg.norm(given)),
            self.surface.radius,
            given,
            np.diag([variance, variance, SIDE**2]),
            np.array([-towards * left[one.axis], left[1 - one.axis]]),
            self.noise**2 * after.covariance[1, 1] * np.eye(2),
            after.times,
            before,
            after,
            float(gaps[2 * one.axis + (towards > 0.0)]),
        )

    def hits(self) -> Iterator[FitEvent]:
        """Yield the clean hits: a rolling ball hits a ball at rest, with no other contact near."""
        for name, other in permutations(self.balls, 2):
            track, target = self.balls[name], self.balls[other]
            gaps = np.linalg.norm(target.at(track.times) - track.positions, axis=1)
            near = dips(gaps - 2.0 * self.surface.radius, _CONTACT_GAP)
            for time in track.times[1:-1][near].tolist():
                found = self._hit(track, target, self._others(name, other), time)
                if found is not None:
                    yield found

    def _hit(
        self, track: Track, target: Track, rest: Sequence[Track], near: float
    ) -> FitEvent | None:
        """Return the hit near a time [s]; None if there is none, or if it isn't clean."""
        before = track.between(near + WINDOW_BEFORE[0], near + WINDOW_BEFORE[1])
        resting = self._resting(target, near + WINDOW_BEFORE[1])
        if len(before.times) < _SAMPLES or not len(resting):
            return None
        origin, place = before.times[0], np.mean(resting, axis=0)
        line = Curve.through(before.times - origin, 1)
        middle, velocity = line.of(before.positions)
        speed, (x, y) = float(np.linalg.norm(velocity)), velocity
        axes = np.array([[x, y], [-y, x]]) / max(speed, Windows.slowest)
        ahead, aside = axes @ (place - middle)
        reach = 2.0 * self.surface.radius
        if speed < Windows.slowest or abs(aside) > _LARGEST_OFFSET * reach:
            return None
        time = origin + line.middle + float(ahead - np.sqrt(reach**2 - aside**2)) / speed
        if abs(time - near) > _TIME_DIFFERENCE or time < before.times[-1]:
            return None
        # The ball rolls until the hit, and both balls have no other contact after it.
        if not (
            has_rolled(track, [*rest, target], self.surface, origin, speed)
            and is_free(track, rest, self.surface, origin, time + _ISOLATION_TIME)
            and is_free(target, rest, self.surface, time, time + _ISOLATION_TIME)
        ):
            return None
        parts = [
            one.between(time + WINDOW_AFTER[0], time + WINDOW_AFTER[1]) for one in (track, target)
        ]
        if min(len(part.times) for part in parts) < _SAMPLES:
            return None
        if line.off(before.positions) > max(Windows.straight, 2.0 * self.noise):
            return None
        first, second = afters = [Curve.through(part.times - origin, 1) for part in parts]
        seen = [
            after.of((part.positions - place) @ axes.T).ravel()
            for after, part in zip(afters, parts, strict=True)
        ]
        variances = self.noise**2 * line.covariance
        places = variances[0, 0] + self.noise**2 / len(resting)
        one, other = (self.noise**2 * np.kron(after.covariance, np.eye(2)) for after in afters)
        zero = np.zeros((4, 4))
        return HitEvent(
            self.name,
            speed,
            self.surface.radius,
            np.array([-ahead, -aside, speed, 0.0, 0.0]),
            np.diag([places, places, variances[1, 1], variances[1, 1], SIDE**2]),
            np.concatenate(seen),
            np.block([[one, zero], [zero, other]]),
            np.union1d(first.times, second.times),
            line,
            (first, second),
        )

    def _resting(self, target: Track, until: float) -> FloatArray:
        """Return the last positions (n, 2) of the other ball up to a time; empty if it moved.

        A tracker may omit a ball while it rests.
        """
        seen = int(np.searchsorted(target.times, until, side="right"))
        places = target.positions[max(seen - _MOST_RESTING, 0) : seen]
        if not len(places):
            return places
        apart = np.linalg.norm(places - places[-1], axis=1)
        moved = np.flatnonzero(apart > max(_REST_DISTANCE, 5.0 * self.noise))
        places = places[moved[-1] + 1 if len(moved) else 0 :]
        left_out = until - target.times[seen - 1] > _OMISSION_TIME
        return places if left_out or len(places) >= _SAMPLES else places[:0]
