"""Simulated oblique hits: the velocities of two balls, and the angle of throw by friction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.simulated_ball import (
    POOL_BALL,
    SNOOKER_BALL,
    BallSize,
    OperatorError,
    Play,
    rolling_deceleration,
)
from ghostball.validation.measured.tracks import Track, tracks_of

_TABLE: Final = Table(length=6.0, width=5.0)
_MIDDLE: Final = (2.0, 2.5)
"""Position of the cue ball at the hit: no ball reaches a cushion during the observation."""
_APPROACH_TIME: Final = 0.2
"""Time before the hit at which a rolling cue ball starts [s]."""
_OBSERVED_TIME: Final = 0.6
"""Time after a hit in which balls are observed [s]: slides end within 0.3 s at snooker speeds."""
_RATE: Final = 200.0  # sampling rate [1/s]
_ROLLING_TIME: Final = 0.2
"""Time after the end of its slide in which each ball's rolling is observed [s]."""
_GAP: Final = 1e-3
"""Gap at which a cue ball without spin starts [m]: the cloth gives it no noticeable spin."""
_THROW_TIMES: Final = (0.02, 0.3)
"""Times at which the direction of a thrown ball is read [s]; it slides and rolls along one line."""
_HEAD_ON_TIMES: Final = (0.004, 0.024)
"""Times after a head-on hit in which balls are observed [s]: soft contacts have ended, and balls
still slide."""


@dataclass(frozen=True)
class ObliqueHit:
    """Two balls when both roll, after a rolling cue ball hit a ball at rest; speeds [m/s].

    Angles are measured from the initial direction of the cue ball, each towards the ball's own side
    [degrees].
    """

    cue_speed: float
    object_speed: float
    cue_angle: float
    object_angle: float


def oblique_hit(
    play: Play, physics: Physics, speed: float, cut: float, size: BallSize = SNOOKER_BALL
) -> ObliqueHit:
    """Return the result of a cue ball that rolls at `speed` [m/s] into a cut [degrees].

    As in the measurement, each ball is read where its slide ends, that is where its deceleration
    drops to that of rolling.

    Raises `OperatorError` if a ball doesn't roll again soon.
    """
    start = speed + rolling_deceleration(physics, speed) * _APPROACH_TIME
    way = (start + speed) / 2.0 * _APPROACH_TIME
    rolls = {"velocity": (start, 0.0)}
    scene = _scene("oblique-hit", physics, size, cut, way, rolls, _APPROACH_TIME + _OBSERVED_TIME)
    tracks = tracks_of(play(scene), _RATE)
    cue, other = (_when_it_rolls(tracks[name], physics, name) for name in ("cue", "object"))
    return ObliqueHit(
        cue_speed=math.hypot(*cue),
        object_speed=math.hypot(*other),
        cue_angle=math.degrees(math.atan2(cue[1], cue[0])),
        object_angle=-math.degrees(math.atan2(other[1], other[0])),
    )


def head_on_hit(
    play: Play, physics: Physics, speed: float, mass_ratio: float
) -> tuple[float, float]:
    """Return the speeds of two balls right after a head-on hit [m/s].

    The hitting ball rolls at `speed` [m/s]; its mass is `mass_ratio` times the other's. While both
    slide, their decelerations are constant, so parabolas through their tracks lead back to the hit.

    Raises `OperatorError` if the object ball isn't hit.
    """
    x, y = _MIDDLE
    apart, mass = 2.0 * POOL_BALL.radius, POOL_BALL.mass
    places, masses = ((x - apart - _GAP, y), (x, y)), (mass * mass_ratio, mass)
    balls = [
        Ball(id=name, position=place, velocity=(v, 0.0), radius=POOL_BALL.radius, mass=one)
        for name, place, v, one in zip(("cue", "object"), places, (speed, 0.0), masses, strict=True)
    ]
    hit = _GAP / speed
    scene = Scene(
        name="head-on", table=_TABLE, physics=physics, balls=balls, t_max=hit + _HEAD_ON_TIMES[1]
    )
    times = np.linspace(*_HEAD_ON_TIMES, 20)
    found = play(scene).sample(hit + times).positions[:, :, 0]
    slopes = [float(np.polyfit(times, found[:, ball], 2)[1]) for ball in (0, 1)]
    if not slopes[1] > 0.0:
        raise OperatorError(f"the object ball doesn't move after a head-on hit at {speed:g} m/s")
    return slopes[0], slopes[1]


def throw_angle(play: Play, physics: Physics, speed: float, cut: float) -> float:
    """Return the throw of a pool ball by a cue ball without spin, at `speed` [m/s] [degrees].

    It is the angle from the line of centres at the hit to the path of the object ball.

    Raises `OperatorError` if the object ball isn't hit.
    """
    slides = {"velocity": (speed, 0.0), "angular_velocity": (0.0, 0.0, 0.0)}
    scene = _scene("throw", physics, POOL_BALL, cut, _GAP, slides, _THROW_TIMES[1] + 2.0 / _RATE)
    return cut - _direction_of(tracks_of(play(scene), _RATE)["object"], speed, cut)


def passed_throw(play: Play, physics: Physics, speed: float, angle: float, gap: float) -> float:
    """Return the throw of a pool ball by a ball that a cue ball without spin hits full [degrees].

    `gap` [m]: between the hit ball and the second ball; 0: they touch. `angle` [degrees] lies
    between the hit and the line of these two balls. The throw is the angle from their line of
    centres when they meet to the path of the second ball. `speed` [m/s] is the cue ball's.

    Raises `OperatorError` if the second ball isn't hit.
    """
    x, y = _MIDDLE
    apart, turn = 2.0 * POOL_BALL.radius, math.radians(angle)
    away = apart + gap
    places = (
        (x - apart - _GAP, y),
        (x, y),
        (x + away * math.cos(turn), y - away * math.sin(turn)),
    )
    motion = {"angular_velocity": (0.0, 0.0, 0.0)}
    balls = [
        Ball(id=name, position=place, velocity=(v, 0.0), **motion, **POOL_BALL._asdict())
        for name, place, v in zip(
            ("cue", "first", "object"), places, (speed, 0.0, 0.0), strict=True
        )
    ]
    lasts = _THROW_TIMES[1] + 2.0 / _RATE
    scene = Scene(name="passed-on", table=_TABLE, physics=physics, balls=balls, t_max=lasts)
    met = math.degrees(math.asin(away * math.sin(turn) / apart))
    return met - _direction_of(tracks_of(play(scene), _RATE)["object"], speed, angle)


def _direction_of(track: Track, speed: float, angle: float) -> float:
    """Return the direction of a ball after a hit, clockwise from x [degrees].

    Raises `OperatorError` if it rests; `speed` [m/s] and `angle` [degrees] describe the hit.
    """
    first, last = track.at(np.array(_THROW_TIMES))
    if not first[0] < last[0]:
        raise OperatorError(
            f"the object ball doesn't move after a hit at {speed:g} m/s, a cut of {angle:g} degrees"
        )
    return math.degrees(math.atan2(first[1] - last[1], last[0] - first[0]))


def _scene(
    name: str,
    physics: Physics,
    size: BallSize,
    cut: float,
    way: float,
    motion: Mapping[str, tuple[float, ...]],
    lasts: float,
) -> Scene:
    """Return two balls; the cue ball moves a distance `way` along x and then hits the other."""
    x, y = _MIDDLE
    apart, angle = 2.0 * size.radius, math.radians(cut)
    place = (x + apart * math.cos(angle), y - apart * math.sin(angle))
    cue = Ball(id="cue", position=(x - way, y), **motion, **size._asdict())
    balls = [cue, Ball(id="object", position=place, **size._asdict())]
    return Scene(name=name, table=_TABLE, physics=physics, balls=balls, t_max=lasts)


def _when_it_rolls(track: Track, physics: Physics, name: str) -> FloatArray:
    """Return the velocity of a ball at the end of its slide [m/s]."""
    steps = np.diff(track.positions, axis=0) * _RATE
    slowing = np.linalg.norm(np.diff(steps, axis=0), axis=1) * _RATE
    sliding = physics.sliding_friction * physics.gravity
    limit = (sliding + rolling_deceleration(physics, 0.0)) / 2.0
    slides = np.flatnonzero(slowing > limit)
    # The samples before, at and after the end of the slide affect the computed deceleration.
    first = int(slides[-1]) + 2 if len(slides) else 0
    last = first + int(_ROLLING_TIME * _RATE)
    if not len(slides) or last >= len(track.times):
        raise OperatorError(
            f"the {name} ball doesn't roll again within {_OBSERVED_TIME:g} s of a hit"
        )
    since = track.times[first:last] - track.times[first]
    line = np.polynomial.polynomial.polyfit(since, track.positions[first:last], 2)
    return np.asarray(line[1])
