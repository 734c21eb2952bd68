"""Cells and a bound for every pair are two schedulers of one engine: the same bits."""

import math
import random

import pytest
from recorded import fingerprint
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.engine import simulate
from ghostball.engine.running import skips
from ghostball.model import Ball, EventKind, Physics, Scene, Status, Table


def many_balls(count, filled=0.4, seed=1, speed=1.0, t_max=None, spread=1.0, **physics) -> Scene:
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
    return Scene(name="many", balls=balls, table=table, physics=Physics(**physics), t_max=t_max)


def both(scene, monkeypatch):
    """Simulate with a bound for every pair, and with cells."""
    results = []
    for most in (10**6, 0):
        monkeypatch.setattr(skips, "MOST_PAIRED", most)
        results.append(simulate(scene.model_copy(), record="events"))
    return results


@pytest.mark.compiled
@pytest.mark.parametrize("spread", [1.0, 4.0])
def test_cells_give_the_same_bits(spread, monkeypatch):
    """Of more balls than random scenes have, which the stress suite asks this of."""
    scene = many_balls(60, 0.5, t_max=1.0, rolling_friction=0.0, spread=spread)
    paired, celled = both(scene, monkeypatch)
    assert len(paired.events) > 100
    assert fingerprint(paired) == fingerprint(celled)
    assert paired.work["cell_moves"] == 0 < celled.work["cell_moves"]


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
def test_many_balls_look_at_their_neighbours_only():
    few, many = (
        simulate(many_balls(count, 0.5, t_max=0.2, rolling_friction=0.0)) for count in (400, 1600)
    )
    per_event = [result.work["bounds"] / result.work["events"] for result in (few, many)]
    assert per_event[1] < 1.2 * per_event[0] < 40.0


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


def test_a_dense_rack_on_a_large_table_needs_few_bounds():
    """Cells that are sized by the whole table alone have hundreds of its balls within reach."""
    balls = [ball((2.0, 3.6), (8.0, 0.0))]
    gap = 2.0 * R + 5e-4
    for row in range(32):
        for k in range(row + 1):
            balls.append(ball((7.0 + row * gap * math.sqrt(0.75), 3.59 + (k - row / 2.0) * gap)))
    scene = scene_of(*balls[:512], table=Table(length=14.4, width=7.2))
    work = simulate(scene, record="rest", max_events=200).work
    assert work["bounds"] < 30 * (work["events"] + work["contact_steps"])


@pytest.mark.compiled
def test_an_event_takes_as_much_work_among_many_balls_as_among_few():
    """A gas of 100 000 met the limit of work: each event counted as if all balls were looked at."""
    few, many = (
        simulate(many_balls(count, t_max=9.0, rolling_friction=0.0), max_work=200_000)
        for count in (400, 6_400)
    )
    assert few.status is many.status is Status.WORK_LIMIT
    assert many.work["events"] == pytest.approx(few.work["events"], rel=0.1)
