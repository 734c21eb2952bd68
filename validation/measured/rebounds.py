"""Rebounds of a three-cushion table, played: what a model makes of what was measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ghostball.model import Ball, Physics, Result, Scene, Table
from ghostball.validation.measured.cushion_contacts import (
    CushionContact,
    Windows,
    cushion_contacts,
)
from ghostball.validation.measured.facts import Row, facts_of
from ghostball.validation.measured.tracks import Surface, tracks_of

Play = Callable[[Scene], Result]
"""What plays a scene and records its motion."""

MEAN_SPEEDS = (0.30, 0.56, 0.85, 1.2, 1.9)
"""The mean speed towards the cushion of what was measured in each bin of the facts [m/s]."""

_RADIUS, _MASS = 0.03075, 0.21
_ROLLS = 0.6  # how long before the contact it begins [s]


_ANY = Windows(slowest=(0.0, 0.0), straight=math.inf)
"""The windows of the measurement, of a contact that is known to be free.

In the slowest bin real ones are faster along the cushion; and a model whose ball still slides in
the windows is to be seen there.
"""


class Rebound(NamedTuple):
    """One bin of the facts, and what a model makes of it."""

    row: Row
    degrees: float  # from the normal
    ratio: float

    @property
    def errors_off(self) -> float:
        """How many standard errors of the measurement the model is above it."""
        assert self.row.error is not None
        return (self.ratio - self.row.value) / self.row.error


def rebounds(play: Play, physics: Physics, degrees: float) -> list[Rebound]:
    """Return what a model makes of each bin, of balls that come at an angle from the normal."""
    rows = facts_of("cushion-carom").rows
    found = []
    for row, speed in zip(rows, MEAN_SPEEDS, strict=True):
        contact = rebound(play, physics, speed, degrees)
        found.append(Rebound(row, degrees, contact.normal_ratio))
    return found


def rebound(play: Play, physics: Physics, speed: float, degrees: float) -> CushionContact:
    """Return the contact of a rolling ball with a mean speed towards the cushion, `speed` [m/s]."""
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
    (contact,) = cushion_contacts(tracks_of(play(scene)), surface, _ANY)
    return contact
