"""Cells and a bound for every pair are two schedulers of one engine: the same bits."""

import math
import random

import numpy as np
import pytest
from recorded import fingerprint
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.engine import (
    Ball,
    EventKind,
    Physics,
    Scene,
    Table,
    simulate,
    simulate_sweep,
)
from ghostball.engine.running import driver, skips
from ghostball.validation.scenes.library import FOLDER
from ghostball.validation.stress.random_breaks import random_break


def crowd(count, filled=0.4, seed=1, speed=1.0, t_max=None, spread=1.0, **physics) -> Scene:
    """Balls on a lattice, off by chance; `spread` is the largest ratio of radii."""
    chance = random.Random(seed)
    length = math.sqrt(count * math.pi * R * R / filled)
    lines = math.ceil(math.sqrt(count))
    step = length / lines
    room = 0.5 * step - 1.01 * R
    balls = []
    for k in range(count):
        turn = chance.uniform(0.0, 2.0 * math.pi)
        place = [(m + 0.5) * step + chance.uniform(-room, room) for m in (k % lines, k // lines)]
        velocity = (speed * math.cos(turn), speed * math.sin(turn))
        radius = R / chance.uniform(1.0, spread)
        balls.append(Ball(id=f"{k}", position=place, velocity=velocity, radius=radius))
    table = Table(length=length, width=length)
    return Scene(name="crowd", balls=balls, table=table, physics=Physics(**physics), t_max=t_max)


# Without the laws that integrate: those would ask for two more sets of kernels to be compiled.
PLAIN_BREAKS = [random_break(number) for number in (1, 2, 6, 9, 11)]


def both(scene, monkeypatch):
    """Simulate with a bound for every pair, and with cells."""
    results = []
    for most in (10**6, 0):
        monkeypatch.setattr(skips, "MOST_PAIRED", most)
        results.append(simulate(scene.model_copy(), record="events"))
    return results


@pytest.mark.compiled
@pytest.mark.parametrize(
    "scene",
    [
        crowd(16, t_max=3.0, rolling_friction=0.0),
        crowd(60, 0.6, t_max=1.0, rolling_friction=0.0),
        crowd(50, 0.3, t_max=2.0, rolling_friction=0.0, spread=4.0),
        # Few large balls among many small ones: two may touch that are two cells apart, were a
        # cell as wide as the mean ball.
        crowd(121, 0.6, t_max=1.0, rolling_friction=0.0, spread=40.0),
        crowd(80, 0.3, speed=2.0, t_max=2.0, rolling_friction=0.0, ball_restitution=0.9),
        Scene.load(FOLDER / "elastic-gas.toml"),
        crowd(80, 0.3, speed=2.0),
        crowd(80, 0.3, speed=3.0, preset="pool"),
        # Without restitution balls press on each other for most of a run, which takes many contact
        # steps: 40 balls are followed for a while, 24 to the end.
        crowd(40, 0.5, t_max=0.2, speed=2.0, preset="pool", ball_restitution=0.0),
        crowd(24, 0.5, speed=2.0, preset="pool", ball_restitution=0.0),
        *PLAIN_BREAKS,
        Scene.load(FOLDER / "frozen-break.toml"),
    ],
    ids=lambda scene: f"{scene.name}-{len(scene.balls)}",
)
def test_cells_give_the_same_bits(scene, monkeypatch):
    paired, celled = both(scene, monkeypatch)
    assert len(paired.events) > 5
    if scene.physics.ball_restitution == 0.0:
        # A floor below what either crowd takes, so that the bits that are compared come of
        # sustained contact and not of impacts alone.
        assert paired.work["contact_steps"] > 9_000
    assert fingerprint(paired) == fingerprint(celled)
    for kind in ("joint_impacts", "contact_steps", "unsolved_contact_steps"):
        assert paired.work[kind] == celled.work[kind]
    assert paired.work["cell_moves"] == 0


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("cushion_first", [False, True])
def test_a_balls_own_event_comes_before_a_contact_of_the_same_instant(
    monkeypatch, turned, cushion_first
):
    """Also while the pair's bound is advanced towards that instant, whichever ball has the slot."""
    gap = 0.25  # [m], to the cushion across and to the ball ahead: met at one instant
    mover = ball((0.5, R + gap), (1.0, -1.0))
    ahead = ball((0.5 + gap + (R if cushion_first else 2 * R), R))
    balls = [ahead, mover] if turned else [mover, ahead]
    scene = scene_of(*balls, table=POOL_TABLE)
    paired, celled = both(scene, monkeypatch)
    assert fingerprint(paired) == fingerprint(celled)


@pytest.mark.parametrize("turned", [False, True])
def test_of_own_events_of_one_instant_a_rest_comes_before_a_cushion(monkeypatch, turned):
    """Whatever the numbering: the order of the log is by kind. All numbers here are exact."""
    rests = ball((2.0, 0.5), (1.0, 0.0), radius=0.25)  # slowed by 1 m/s^2: at t = 1 s
    bounces = ball((1.25, 2.0), (-1.0, 0.0), radius=0.25, rolling_friction=0.0)  # over 1 m
    balls = [bounces, rests] if turned else [rests, bounces]
    table = Table(length=8.0, width=4.0)
    scene = scene_of(*balls, table=table, gravity=8.0, rolling_friction=0.125, t_max=1.5)
    for result in both(scene, monkeypatch):
        assert result.events["t"].tolist() == [1.0, 1.0]
        kinds = [EventKind.ROLL_TO_REST, EventKind.BALL_CUSHION]
        assert [EventKind(kind) for kind in result.events["kind"]] == kinds
        assert result.events["a"].tolist() == ([1, 0] if turned else [0, 1])


@pytest.mark.compiled
def test_symmetric_impacts_one_after_the_other(monkeypatch):
    """Equal speeds at one instant: the order follows from places, not from who looks for them."""
    balls = [
        ball((0.2 + 0.2 * column, 0.2 + 0.2 * row), (0.5 if column % 2 == 0 else -0.5, 0.0))
        for row in range(4)
        for column in range(6)
    ]
    scene = scene_of(*balls, table=POOL_TABLE, impacts="sequential")
    paired, celled = both(scene, monkeypatch)
    assert fingerprint(paired) == fingerprint(celled)
    assert celled.collision_counts["ball-ball"] > 20


@pytest.mark.compiled
def test_a_run_goes_on_where_it_stopped(monkeypatch):
    """After every event, after a full log, and with contacts once they are needed."""
    scene = crowd(14, 0.5, seed=2, speed=2.0, preset="pool", ball_restitution=0.3)
    monkeypatch.setattr(skips, "MOST_PAIRED", 0)
    whole = simulate(scene, record="events")
    monkeypatch.setattr(driver.Run.play, "__defaults__", (1,))
    monkeypatch.setattr(driver, "_FIRST_LOG", 2 + 5 * 14)
    assert fingerprint(simulate(scene, record="events")) == fingerprint(whole)
    assert whole.work["contact_steps"] > 1000


@pytest.mark.compiled
def test_a_sweep_in_cells_is_each_of_its_shots(monkeypatch):
    scene = crowd(30, 0.2, rolling_friction=0.02)
    monkeypatch.setattr(skips, "MOST_PAIRED", 0)
    swept = simulate_sweep(scene, [1.0, 2.0, 1.0], [0.1, 0.2, 0.1], threads=1)
    assert np.array_equal(swept.rest_positions[0], swept.rest_positions[2])
    monkeypatch.setattr(skips, "MOST_PAIRED", 10**6)
    paired = simulate_sweep(scene.model_copy(), [1.0, 2.0, 1.0], [0.1, 0.2, 0.1], threads=1)
    assert np.array_equal(swept.rest_positions, paired.rest_positions)
    assert np.array_equal(swept.events, paired.events)


@pytest.mark.compiled
def test_many_balls_look_at_their_neighbours_only():
    few, many = (
        simulate(crowd(count, 0.5, t_max=0.2, rolling_friction=0.0)) for count in (400, 1600)
    )
    per_event = [result.work["bounds"] / result.work["events"] for result in (few, many)]
    assert per_event[1] < 1.2 * per_event[0] < 40.0


@pytest.mark.compiled
def test_a_rack_on_an_unbounded_cloth(monkeypatch):
    scene = scene_of(
        ball((0.0, 0.003), (6.0, 0.0)),
        *rack(15, (1.0, 0.0), 1e-5),
        rolling_friction=0.0,
        t_max=1.0,
    )
    paired, celled = both(scene, monkeypatch)
    assert celled.work["cell_moves"] > 0
    assert fingerprint(paired) == fingerprint(celled)


def test_a_few_balls_in_cells_without_a_compiler(monkeypatch):
    scene = scene_of(
        ball((0.6, 0.635), (1.0, 0.02)),
        *rack(3, (1.9, 0.635), 1e-4),
        table=POOL_TABLE,
        rolling_friction=0.0,
        t_max=3.0,
    )
    paired, celled = both(scene, monkeypatch)
    assert celled.work["cell_moves"] > 0
    assert fingerprint(paired) == fingerprint(celled)
