"""Rebounds from cushions, played: what a model makes of what was measured."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.measured.cushion_contacts import (
    CushionContact,
    Windows,
    cushion_contacts,
)
from ghostball.validation.measured.facts import Row, facts_of
from ghostball.validation.measured.play import (
    CAROM_BALL,
    SNOOKER_BALL,
    OperatorError,
    Play,
    rolling_deceleration,
)
from ghostball.validation.measured.tracks import Surface, Track, tracks_of

_ROLLS = 0.6  # how long before the contact it begins [s]
_PLAYED = 1.45  # until the contact has been alone for long enough [s]

_ANY = Windows(slowest=0.0, straight=math.inf)
"""The windows of the measurement, of a contact that is known to be free: what a model's ball still
does in them is to be seen, if it slides or creeps.
"""

_COMES: Final = 0.1
"""How long before a square contact the ball begins [s]."""
_AT_IMPACT: Final = (0.005, 0.035)
"""From when to when, before and after, a square contact is read [s]: what a soft cushion of an
engine takes is over, and the slowest ball still slides."""
_RATE: Final = 1000.0  # of samples [1/s]


class Rebound(NamedTuple):
    """One bin of the facts, and what a model makes of it."""

    row: Row
    ratio: float

    @property
    def errors_off(self) -> float:
        """How many standard errors of the measurement the model is above it."""
        assert self.row.error is not None
        return (self.ratio - self.row.value) / self.row.error


def rebounds(play: Play, physics: Physics, degrees: float) -> list[Rebound]:
    """Return what a model makes of each bin, of balls that come at an angle from the normal."""
    found = []
    for row in facts_of("cushion-carom").rows:
        assert row.at is not None
        found.append(Rebound(row, rebound(play, physics, row.at, degrees).normal_ratio))
    return found


def rebound(play: Play, physics: Physics, speed: float, degrees: float) -> CushionContact:
    """Return the contact of a rolling ball with a mean speed towards the cushion, `speed` [m/s].

    Raises `OperatorError` where the ball doesn't bounce once.
    """
    angle, middle = math.radians(degrees), -sum(Windows().before) / 2.0
    total = speed / math.cos(angle)
    slowing = rolling_deceleration(physics, total)
    start = total + slowing * (_ROLLS - middle)
    way = (start - slowing * _ROLLS / 2.0) * _ROLLS
    table = Table(length=way * math.cos(angle) + 1.0, width=3.0 * way + 1.0)
    radius, mass = CAROM_BALL
    place = (table.length - radius - way * math.cos(angle), 0.2)
    velocity = (start * math.cos(angle), start * math.sin(angle))
    scene = Scene(
        name="rebound",
        table=table,
        physics=physics,
        t_max=_PLAYED,
        balls=[Ball(id="cue", position=place, velocity=velocity, radius=radius, mass=mass)],
    )
    surface = Surface(table.length, table.width, radius)
    contacts = cushion_contacts(tracks_of(play(scene)), surface, _ANY)
    if len(contacts) != 1:
        raise OperatorError(
            f"a ball that came to a cushion at {speed:g} m/s, {degrees:g} degrees from the normal, "
            f"bounced {len(contacts)} times in {_PLAYED:g} s where it should once"
        )
    return contacts[0]


def square_rebound(play: Play, physics: Physics, speed: float) -> CushionContact:
    """Return the contact of a rolling snooker ball that meets a cushion square on, at `speed`.

    The speeds are those right before and right after it [m/s], as the measurement reads them from
    its plots of speed; the ball slides then, and parabolas through its positions follow that.

    Raises `OperatorError` where the ball doesn't come back.
    """
    slowing = rolling_deceleration(physics, speed)
    start = speed + slowing * _COMES
    radius, mass = SNOOKER_BALL
    table = Table(length=4.0, width=2.0)
    way = (start + speed) / 2.0 * _COMES
    position = (table.length - radius - way, table.width / 2.0)
    ball = Ball(id="cue", position=position, velocity=(start, 0.0), radius=radius, mass=mass)
    scene = Scene(
        name="square-rebound", table=table, physics=physics, t_max=2.0 * _COMES, balls=[ball]
    )
    track = tracks_of(play(scene), _RATE)["cue"]
    time = float(track.times[np.argmax(track.positions[:, 0])])
    before, after = (_speed_at(track, time, sign) for sign in (-1.0, 1.0))
    if not before > 0.0 > after:
        raise OperatorError(
            f"a ball that came square to a cushion at {speed:g} m/s left it at {-after:.3g} m/s"
        )
    return CushionContact("cue", time, 0, before, -after)


def _speed_at(track: Track, time: float, sign: float) -> float:
    """Return the speed along x at a contact, from a parabola through what is before or after."""
    since = sign * (track.times - time)
    seen = (since >= _AT_IMPACT[0]) & (since <= _AT_IMPACT[1])
    line = np.polynomial.polynomial.polyfit(track.times[seen] - time, track.positions[seen, 0], 2)
    return float(line[1])
