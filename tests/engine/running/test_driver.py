"""Logs that fill up, and runs that come to need contacts: nothing is lost or kept twice."""

from __future__ import annotations

import pytest
from kernels import begins_without_contacts
from recorded import fingerprint
from shots import R

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.engine.running import driver
from ghostball.engine.running.room import Limits
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


@begins_without_contacts
@pytest.mark.parametrize(
    "scene",
    [  # one for each of the places where a run finds that it needs contacts
        driven_into_a_cushion(),
        Scene.load(FOLDER / "push-line.toml"),
        Scene.load(FOLDER / "three-ball-symmetric.toml"),
    ],
    ids=lambda scene: scene.name,
)
def test_a_run_that_comes_to_contacts_continues_as_with_them_from_the_first(scene):
    with_them = simulate(scene, record="events", no_skip=["contacts"])
    beginning = driver.Run(scene, keep_log=False)
    assert beginning._room.contacts is None
    beginning.play(Limits(events=65_536, work=10**9), budget=10**9)
    assert beginning._counters[st.STATUS] == st.RUN_CONTACTS
    assert fingerprint(simulate(scene, record="events")) == fingerprint(with_them)
