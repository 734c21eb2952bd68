"""Which events of tracks are clean: what a ball does alone, long after it met anything."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ghostball.validation.measured.cushion_contacts import (
    CushionContact,
    Windows,
    cushion_contacts,
)
from ghostball.validation.measured.fit.alone import has_rolled
from ghostball.validation.measured.fit.events import CushionEvent, Event, RollingEvent
from ghostball.validation.measured.fit.hits import hits
from ghostball.validation.measured.fit.lines import Curve, noise_of, window, without_stale
from ghostball.validation.measured.rolling import Rolling, RollingWindows, rolling_windows
from ghostball.validation.measured.tracks import Shots, Surface, Track

CUSHION = Windows(before=(-0.30, -0.02), alone=(-0.30, 0.80), near=0.05, samples=5)
"""As the published measurement has it, but for a window before that is shorter, so that more balls
have rolled long before; and that a ball may be anywhere near where a slow camera sees it last.
"""
ROLLING = RollingWindows(after=1.0)
_LEAST_NOISE = 1e-5
"""Noise that a track without any is taken to have [m]: it was rounded when it was written."""


@dataclass(frozen=True)
class Harvest:
    """The clean events of a table's tracks, and the noise of a coordinate of a sample [m]."""

    rolling: Sequence[Event]
    cushion: Sequence[Event]
    hit: Sequence[Event]
    noise: float

    @property
    def families(self) -> Mapping[str, Sequence[Event]]:
        """The events by what they are."""
        return {"rolling": self.rolling, "cushion": self.cushion, "hit": self.hit}


def harvest(shots: Shots, surface: Surface) -> Harvest:
    """Return the clean events of all shots."""
    fresh = {
        shot: {ball: without_stale(track) for ball, track in balls.items()}
        for shot, balls in shots.items()
    }
    noise = noise_of([track for balls in fresh.values() for track in balls.values()])
    least = max(noise, _LEAST_NOISE)
    return Harvest(
        [one for shot, balls in fresh.items() for one in _rolling(shot, balls, surface, least)],
        [one for shot, balls in fresh.items() for one in _cushions(shot, balls, surface, least)],
        [one for shot, balls in fresh.items() for one in hits(shot, balls, surface, least)],
        noise,
    )


def _rolling(
    shot: str, balls: Mapping[str, Track], surface: Surface, noise: float
) -> Iterator[Event]:
    """Yield the windows in which a ball rolls."""
    off = max(ROLLING.off, 5.0 * noise)
    for one in rolling_windows(balls, surface, replace(ROLLING, off=off)):
        yield _rolling_event(shot, balls[one.ball], one, noise, surface.radius)


def _rolling_event(shot: str, track: Track, one: Rolling, noise: float, radius: float) -> Event:
    half = ROLLING.length / 2.0
    samples = window(track, one.time - half, one.time + half)
    curve = Curve.through(samples.times - samples.times[0], 2)
    return RollingEvent.of(shot, curve, samples.positions, noise, radius)


def _cushions(
    shot: str, balls: Mapping[str, Track], surface: Surface, noise: float
) -> Iterator[Event]:
    """Yield the free contacts with a cushion of balls that rolled there."""
    straight = max(CUSHION.straight, 2.0 * noise)
    for one in cushion_contacts(balls, surface, replace(CUSHION, straight=straight)):
        others = [other for name, other in balls.items() if name != one.ball]
        found = _cushion_event(shot, balls[one.ball], others, one, surface, noise)
        if found is not None:
            yield found


def _cushion_event(
    shot: str,
    track: Track,
    others: Sequence[Track],
    one: CushionContact,
    surface: Surface,
    noise: float,
) -> Event | None:
    before = window(track, *(one.time + edge for edge in CUSHION.before))
    after = window(track, *(one.time + edge for edge in CUSHION.after))
    origin = before.times[0]
    lines = tuple(Curve.through(part.times - origin, 1) for part in (before, after))
    place, velocity = lines[0].of(before.positions)
    if not has_rolled(track, others, surface, origin, float(np.linalg.norm(velocity))):
        return None
    left = lines[1].of(after.positions)[1]
    towards = 1.0 if velocity[one.axis] > 0.0 else -1.0
    gaps = surface.gaps(place - lines[0].middle * velocity)
    return CushionEvent.of(
        shot,
        (lines[0], lines[1]),
        (
            np.array([towards * velocity[one.axis], velocity[1 - one.axis]]),
            np.array([-towards * left[one.axis], left[1 - one.axis]]),
        ),
        float(gaps[2 * one.axis + (towards > 0.0)]),
        noise,
        surface.radius,
    )
