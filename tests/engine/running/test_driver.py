"""Tests of logs that fill up: no event or motion is lost or stored twice."""

from __future__ import annotations

from recorded import fingerprint

from ghostball.engine import simulate
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.engine.running import driver
from ghostball.model import Scene
from ghostball.validation.scenes.library import FOLDER


def test_events_and_motions_are_the_same_however_many_logs_hold_them(monkeypatch):
    scene = Scene.load(FOLDER / "galperin-3.toml")
    whole = simulate(scene, record="trajectory")
    monkeypatch.setattr(driver, "_FIRST_LOG", MOST_IN_CORNER + 64)
    assert fingerprint(simulate(scene, record="trajectory")) == fingerprint(whole)
