"""No shot holds the kernels: loops count their turns, pauses change nothing, limits end it."""

from __future__ import annotations

import math
import os
import signal
import threading

import numpy as np
import pytest
from kernels import begins_without_contacts
from recorded import fingerprint
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import simulate, simulate_many
from ghostball.engine.core.rows import MEMBER_COLUMNS
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.engine.running import driver, room, skips
from ghostball.model import Scene, Status, Table
from ghostball.validation.scenes.library import FOLDER

R = 0.028575
K = 0.0041


def along_a_cushion(**physics) -> Scene:
    return scene_of(ball((0.5, R), (1.0, 0.0)), table=POOL_TABLE, air_drag=K, **physics)


def displacement_in_air(speed: float) -> float:
    """Return how far a ball of the paper's rolls in air [m]: v dv/dx = -(mu g + k v^2)."""
    return math.log1p(K * speed * speed / (0.02 * 9.81)) / (2.0 * K)


def test_a_ball_in_air_along_a_cushion_that_it_touches_rolls_as_one_in_the_middle():
    """The bound took the jerk along the cushion, too: the kernel never returned."""
    result = simulate(along_a_cushion(), max_work=10**5)
    far = 0.5 + displacement_in_air(1.0)
    mirrored = 2.0 * (POOL_TABLE.length - R) - far
    assert result.status is Status.REST
    assert result.rest_positions[0] == pytest.approx([mirrored, R, R], abs=1e-13)
    assert result.collision_counts["ball-cushion"] == 1


@pytest.mark.parametrize("preset", ["pool", "pool-coulomb"])
@pytest.mark.parametrize("width", [1.27, 2.0 * R], ids=["table", "channel"])
@pytest.mark.parametrize("spin", [None, (0.0, 0.0, 0.0), (5.0, -3.0, 20.0)])
def test_a_ball_that_slides_along_a_cushion_in_air_ends(preset, width, spin):
    scene = scene_of(
        ball((0.5, R), (1.0, 0.0), **({} if spin is None else {"angular_velocity": spin})),
        table=Table(length=2.54, width=width), preset=preset, air_drag=K,
    )  # fmt: skip
    assert simulate(scene, max_work=10**7).status is Status.REST


@pytest.mark.compiled
def test_two_balls_frozen_into_a_corner_in_air_end():
    scene = scene_of(
        ball(
            (0.2080354702103901, 0.10498377100129791),
            (-4.834549850558149, -3.020199430107958),
            angular_velocity=(18.92442777002959, -37.9390405146109, -22.997302566648262),
        ),
        ball((R, R)), ball((3.0 * R, R)),
        table=POOL_TABLE, preset="pool-coulomb", air_drag=K, ball_restitution=0.0,
    )  # fmt: skip
    assert simulate(scene, max_work=10**7).status is Status.REST


ON_CLOTH = ["break-7", "frozen-triangle", "push-line"]
PLAYED = [
    *((name, many) for name in ON_CLOTH for many in (False, True)),
    ("air-slides", False),  # in cells they need kernels that no other test does
    ("flight-jump", False),
]


def pause_at_every_step(monkeypatch):
    monkeypatch.setattr(driver.Run.play, "__defaults__", (1,))


def fill_scratch_with_nan(monkeypatch):
    made = room.Room.__init__

    def poisoned(self, layout, with_contacts):
        made(self, layout, with_contacts)
        self.numbers[:] = math.nan
        if self.contacts is not None:
            self.contacts[2][layout.count * MEMBER_COLUMNS :] = math.nan

    monkeypatch.setattr(room.Room, "__init__", poisoned)


@pytest.mark.compiled
@pytest.mark.parametrize("disturb", [pause_at_every_step, fill_scratch_with_nan])
@pytest.mark.parametrize(("name", "many"), PLAYED)
def test_neither_pauses_nor_what_is_in_scratch_change_a_bit(name, many, disturb, monkeypatch):
    """Nothing in a block is read before it is written, and a shot continues where it paused."""
    if many:
        monkeypatch.setattr(skips, "MOST_PAIRED", 0)
    scene = Scene.load(FOLDER / f"{name}.toml")
    whole = simulate(scene.model_copy(), record="events")
    disturb(monkeypatch)
    other = simulate(scene.model_copy(), record="events")
    assert fingerprint(other) == fingerprint(whole)
    assert other.work == whole.work


@pytest.mark.compiled
def test_a_ball_that_bounces_without_room_and_without_loss_stands_still():
    """Between two noses as wide apart as it is, each impact is at the same instant."""
    scene = scene_of(
        ball((0.5, R), (1.0, 0.1)), table=Table(length=2.54, width=2.0 * R), cushion="mirror"
    )
    result = simulate(scene)
    assert result.status is Status.ENDLESS
    assert "the clock stands still" in result.reason
    lossy = scene_of(
        ball((0.5, R), (1.0, 0.1)), table=Table(length=2.54, width=2.0 * R),
        cushion="restitution", cushion_restitution=0.85,
    )  # fmt: skip
    assert simulate(lossy, max_work=10**6).status is Status.REST


def test_a_limit_ends_a_shot_and_says_what_was_done():
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.3)), table=POOL_TABLE, rolling_friction=0.0, t_max=9e9
    )
    result = simulate(scene, max_work=1_000)
    assert result.status is Status.WORK_LIMIT
    assert not result.status.complete
    assert "events" in result.reason
    assert "work 100" in result.reason
    assert result.settings["max_work"] == 1_000
    assert 0.0 < result.rest_time < 9e9
    few = simulate(scene, record="events", max_events=5)
    assert (few.status, len(few.events)) == (Status.EVENT_LIMIT, 5)
    assert "5 events" in few.reason
    assert few.rest_time == few.events["t"][-1]
    batch = simulate_many([scene], max_work=1_000)
    assert batch.rest_times[0] == result.rest_time
    assert not batch.complete[0]


@pytest.mark.parametrize("record", ["rest", "trajectory"])
def test_ctrl_c_before_the_kernel_was_called_leaves_all_balls_where_they_begin(monkeypatch, record):
    """It continued in arrays that nobody had filled, and the process crashed now and then."""
    whole = room.Room.play
    interrupts = iter([True])

    def play(self, *arguments, **budget):
        self.numbers[:] = np.nan  # what new memory holds is anybody's guess
        if next(interrupts, False):
            raise KeyboardInterrupt
        return whole(self, *arguments, **budget)

    monkeypatch.setattr(room.Room, "play", play)
    scene = Scene.load(FOLDER / "break-16.toml")
    result = simulate(scene, record=record)
    assert result.status is Status.INTERRUPTED
    assert result.rest_time == 0.0
    assert result.work["events"] == 0
    np.testing.assert_array_equal(result.rest_positions, scene.positions)


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

    monkeypatch.setattr(driver.Run, "take_contacts", interrupted)
    with pytest.raises(KeyboardInterrupt):
        simulate(Scene.load(FOLDER / "push-line.toml"))


@pytest.mark.compiled
def test_a_shot_without_end_hears_ctrl_c_and_keeps_what_is_done():
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.3)), table=POOL_TABLE, rolling_friction=0.0, t_max=1e50
    )
    simulate(scene, max_events=2)
    interrupt = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    interrupt.start()
    result = simulate(scene, max_events=2**62, max_work=2**62)
    interrupt.join()
    assert result.status is Status.INTERRUPTED
    assert np.all(np.isfinite(result.rest_positions))
    assert result.work["events"] > 0
