"""Logs that fill up: no event or motion is lost or kept twice."""

from __future__ import annotations

from recorded import fingerprint
from shots import R

from ghostball.engine import simulate
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.engine.running import driver
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.scenes.library import FOLDER


def test_events_and_motions_are_the_same_however_many_logs_hold_them(monkeypatch):
    scene = Scene.load(FOLDER / "galperin-3.toml")
    whole = simulate(scene, record="trajectory")
    monkeypatch.setattr(driver, "_FIRST_LOG", MOST_IN_CORNER + 64)
    assert fingerprint(simulate(scene, record="trajectory")) == fingerprint(whole)


def driven_into_a_cushion():
    """A ball at rest at a cushion, whose spin drives it there."""
    spinning = Ball(id="ball", radius=R, position=(R, 0.5), angular_velocity=(0.0, -60.0, 0.0))
    table, physics = Table(length=1.0, width=1.0), Physics(motion="sliding")
    return Scene(name="driven", table=table, physics=physics, balls=[spinning])
