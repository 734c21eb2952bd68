"""Simulated rebounds from cushions, evaluated like the measured ones."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ghostball.model import Physics, Table
from ghostball.validation.measured.cushion_contacts import CushionContact, Windows, cushion_contacts
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.figures import ComparedFigure
from ghostball.validation.measured.simulated_ball import (
    CAROM_BALL,
    SNOOKER_BALL,
    OperatorError,
    Play,
    rolling_deceleration,
    track_of,
)
from ghostball.validation.measured.tracks import Surface, Track

_LEAD_TIME = 0.6  # time from the start to the contact [s]
_DURATION = 1.45  # duration that covers the window after the contact [s]

_ANY_CONTACT = Windows(slowest=0.0, straight=math.inf)
"""The windows of the measurement for a contact that is known to be free; slides and slow balls
count.
"""

_APPROACH_TIME: Final = 0.1
"""Time from the start to a perpendicular contact [s]."""
_IMPACT_WINDOW: Final = (0.005, 0.035)
"""Times before and after a perpendicular contact between which the speed is read [s]: contacts with
the soft cushion of an engine have ended, and even the slowest ball still slides."""
_RATE: Final = 1000.0  # sampling rate [1/s]


def rebounds(play: Play, physics: Physics, degrees: float) -> list[ComparedFigure]:
    """Return the simulated value for each bin, for balls at an angle from the normal."""
    return [
        ComparedFigure.of(row, rebound(play, physics, row.place, degrees).normal_ratio)
        for row in facts_of("cushion-carom").rows
    ]


def rebound(play: Play, physics: Physics, speed: float, degrees: float) -> CushionContact:
    """Return the contact of a rolling ball; `speed` is its mean normal speed before it [m/s].

    Raises `OperatorError` if the ball doesn't bounce exactly once.
    """
    angle, middle = math.radians(degrees), -sum(Windows().before) / 2.0
    total = speed / math.cos(angle)
    slowing = rolling_deceleration(physics, total)
    start = total + slowing * (_LEAD_TIME - middle)
    way = (start - slowing * _LEAD_TIME / 2.0) * _LEAD_TIME
    table = Table(length=way * math.cos(angle) + 1.0, width=3.0 * way + 1.0)
    track = track_of(
        play,
        physics,
        table,
        CAROM_BALL,
        position=(table.length - CAROM_BALL.radius - way * math.cos(angle), 0.2),
        velocity=(start * math.cos(angle), start * math.sin(angle)),
        lasts=_DURATION,
    )
    surface = Surface(table.length, table.width, CAROM_BALL.radius)
    contacts = cushion_contacts({"cue": track}, surface, _ANY_CONTACT)
    if len(contacts) != 1:
        raise OperatorError(
            f"a ball that hit a cushion at {speed:g} m/s, {degrees:g} degrees from the normal, "
            f"bounced {len(contacts)} times in {_DURATION:g} s instead of once"
        )
    return contacts[0]


def square_rebound(play: Play, physics: Physics, speed: float) -> CushionContact:
    """Return the perpendicular contact of a rolling snooker ball with a cushion, at `speed` [m/s].

    The speeds are those just before and just after it [m/s], which the measurement reads from plots
    of the speed. The ball slides then, so parabolas are fitted to its positions.

    Raises `OperatorError` if the ball doesn't come back.
    """
    slowing = rolling_deceleration(physics, speed)
    start = speed + slowing * _APPROACH_TIME
    table = Table(length=4.0, width=2.0)
    way = (start + speed) / 2.0 * _APPROACH_TIME
    track = track_of(
        play,
        physics,
        table,
        SNOOKER_BALL,
        position=(table.length - SNOOKER_BALL.radius - way, table.width / 2.0),
        velocity=(start, 0.0),
        lasts=2.0 * _APPROACH_TIME,
        rate=_RATE,
    )
    time = float(track.times[np.argmax(track.positions[:, 0])])
    before, after = (_speed_at(track, time, sign) for sign in (-1.0, 1.0))
    if not before > 0.0 > after:
        raise OperatorError(
            f"a ball that hit a cushion squarely at {speed:g} m/s left it at {-after:.3g} m/s"
        )
    return CushionContact("cue", time, 0, before, -after)


def _speed_at(track: Track, time: float, sign: float) -> float:
    """Return the speed along x at a contact, from a parabola before (-1) or after (1) it."""
    since = sign * (track.times - time)
    seen = (since >= _IMPACT_WINDOW[0]) & (since <= _IMPACT_WINDOW[1])
    line = np.polynomial.polynomial.polyfit(track.times[seen] - time, track.positions[seen, 0], 2)
    return float(line[1])
