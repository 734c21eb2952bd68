"""Ctrl-C within a run: nothing is lost, and nothing is kept twice."""

from __future__ import annotations

import numpy as np
import pytest
from kernels import begins_without_contacts
from recorded import fingerprint
from shots import R

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.engine.running import driver
from ghostball.engine.running.room import Limits, Room
from ghostball.model import Ball, Physics, Scene, Status, Table
from ghostball.validation.scenes.library import FOLDER


def test_ctrl_c_while_a_full_log_is_replaced_loses_no_event_and_keeps_none_twice(monkeypatch):
    """Between two of its lines, events were lost, and others were what new memory held."""
    scene = Scene.load(FOLDER / "galperin-3.toml")
    whole = simulate(scene, record="events")
    larger, calls = driver.log_of, iter([False, False, True])  # the first two logs are had

    def log_of(*arguments):
        if next(calls, False):
            raise KeyboardInterrupt
        return larger(*arguments)

    monkeypatch.setattr(driver, "_FIRST_LOG", MOST_IN_CORNER + 64)
    monkeypatch.setattr(driver, "log_of", log_of)
    result = simulate(scene, record="events")
    done = len(result.events)
    assert result.status is Status.INTERRUPTED
    assert 64 < done < len(whole.events)
    np.testing.assert_array_equal(result.events, whole.events[:done])
    until = simulate(scene, max_events=done)
    np.testing.assert_array_equal(result.rest_positions, until.rest_positions)


def test_ctrl_c_within_the_change_of_logs_changes_nothing(monkeypatch):
    scene = Scene.load(FOLDER / "galperin-3.toml")
    whole = simulate(scene, record="trajectory")
    take = driver.Run._take_next_log

    def take_twice(run):
        change = run._next_log
        take(run)
        run._next_log = change  # as if interrupted before its last line
        take(run)

    monkeypatch.setattr(driver, "_FIRST_LOG", MOST_IN_CORNER + 64)
    monkeypatch.setattr(driver.Run, "_take_next_log", take_twice)
    assert fingerprint(simulate(scene, record="trajectory")) == fingerprint(whole)


@begins_without_contacts
def test_ctrl_c_while_contacts_are_compiled_is_raised(monkeypatch):
    """There is no place of a ball to return: the kernel waits in the middle of an event."""

    def interrupted(run):
        raise KeyboardInterrupt

    monkeypatch.setattr(Room, "take_contacts", interrupted)
    with pytest.raises(KeyboardInterrupt):
        simulate(Scene.load(FOLDER / "push-line.toml"))


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
