"""Rebounds of a three-cushion table, played: what a model makes of what was measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ghostball.model import Ball, GhostballError, Physics, Result, Scene, Table
from ghostball.validation.measured.cushion_contacts import (
    CushionContact,
    Windows,
    cushion_contacts,
)
from ghostball.validation.measured.facts import Row, facts_of
from ghostball.validation.measured.tracks import Surface, tracks_of

Play = Callable[[Scene], Result]
"""What plays a scene and records its motion."""

_RADIUS, _MASS = 0.03075, 0.21
_ROLLS = 0.6  # how long before the contact it begins [s]

_ANY = Windows(slowest=0.0, straight=math.inf)
"""The windows of the measurement, of a contact that is known to be free: what a model's ball still
does in them is to be seen, if it slides or creeps.
"""


class ReboundError(GhostballError):
    """A ball that doesn't bounce as it should."""


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

    Raises `ReboundError` where the ball doesn't bounce once.
    """
    angle, middle = math.radians(degrees), -sum(Windows().before) / 2.0
    total = speed / math.cos(angle)
    slowing = physics.rolling_friction * physics.gravity
    slowing += physics.rolling_friction_quadratic * total**2
    start = total + slowing * (_ROLLS - middle)
    way = (start - slowing * _ROLLS / 2.0) * _ROLLS
    table = Table(length=way * math.cos(angle) + 1.0, width=3.0 * way + 1.0)
    place = (table.length - _RADIUS - way * math.cos(angle), 0.2)
    velocity = (start * math.cos(angle), start * math.sin(angle))
    scene = Scene(
        name="rebound",
        table=table,
        physics=physics,
        t_max=2.0,
        balls=[Ball(id="cue", position=place, velocity=velocity, radius=_RADIUS, mass=_MASS)],
    )
    surface = Surface(table.length, table.width, _RADIUS)
    contacts = cushion_contacts(tracks_of(play(scene)), surface, _ANY)
    if len(contacts) != 1:
        raise ReboundError(
            f"a ball that came to a cushion at {speed:g} m/s, {degrees:g} degrees from the normal, "
            f"bounced {len(contacts)} times in 2 s where it should once"
        )
    return contacts[0]
