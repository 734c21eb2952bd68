"""Tests of the engine's interface: arguments are checked, and results are consistent.

Scenes created without validation are rejected on every path to the kernels, no scene makes a kernel
write beyond its arrays, and the same scene gives the same bits.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from recorded import fingerprint
from shots import POOL_TABLE, R, ball, crowded_table, scene_of

from ghostball.engine import simulate, simulate_many, simulate_sweep
from ghostball.engine.sensitivity import tangent_of
from ghostball.model import (
    EVENT_DTYPE,
    Ball,
    EventKind,
    GhostballError,
    Physics,
    Scene,
    SceneError,
    Status,
    UnsupportedSceneError,
)
from ghostball.validation.scenes.library import find_scene

BASELINES = Path(__file__).parents[2] / "benchmarks" / "baselines" / "ghostball"

SHOT = scene_of(
    ball((0.3, 0.3), (2.0, 0.1)), ball((0.8, 0.32)), ball((0.86, 0.36)), table=POOL_TABLE
)


def with_ball(scene, i, **fields):
    balls = list(scene.balls)
    balls[i] = balls[i].model_copy(update=fields)
    return scene.model_copy(update={"balls": tuple(balls)})


def heap():
    """Return ten balls within 1 mm, which all touch: 45 pairs, with memory for 31."""
    balls = tuple(
        Ball(id=f"b{k}", position=(0.5 + 1e-4 * k, 0.5), velocity=(1.0 - 0.1 * k, 0.0))
        for k in range(10)
    )
    return SHOT.model_copy(update={"balls": balls})


def paths(scene):
    """Yield every path from a scene to a kernel."""
    recorded = simulate(SHOT, record="trajectory")
    change = np.ones((1, len(scene.balls), 7))
    yield lambda: simulate(scene)
    yield lambda: simulate(scene, no_skip=["air-and-flight"])
    yield lambda: simulate_many([SHOT, scene])
    yield lambda: simulate_sweep(scene, 1.0, [0.0, 0.1])
    yield lambda: tangent_of(scene, recorded.trajectory, recorded.events, change)


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        (heap(), "overlap by"),
        (with_ball(SHOT, 1, velocity=(0.0, math.nan, 0.0)), "`balls[1].velocity[1]` must be a fin"),
        (with_ball(SHOT, 1, mass=math.inf), "`balls[1].mass` must be a finite number, got inf"),
        (with_ball(SHOT, 2, radius=-R), "`balls[2].radius` must be greater than 0"),
        (SHOT.model_copy(update={"t_max": math.nan}), "`t_max` must be a finite number"),
        (SHOT.model_copy(update={"balls": ()}), "`balls` must have at least 1"),
        (SHOT.model_copy(update={"balls": list(SHOT.balls)}), "would have changed it"),
        (Scene.model_construct(name="none"), "`balls` must be given"),
        (
            SHOT.model_copy(
                update={"physics": SHOT.physics.model_copy(update={"ball_restitution": 1.5})}
            ),
            "`physics.ball_restitution` must be at most 1",
        ),
    ],
    ids=["heap", "nan", "inf", "radius", "t_max", "empty", "list", "missing", "law"],
)
def test_a_scene_made_without_its_checks_is_refused_on_every_path(scene, says):
    # If the heap weren't rejected, a compiled kernel would write beyond an array.
    paths_of = paths(scene) if "balls" in scene.__dict__ else [lambda: simulate(scene)]
    for path in paths_of:
        with pytest.raises(SceneError, match="created without validation") as caught:
            path()
        assert says in str(caught.value)


FIELDS = [
    *((field, axis) for field in ("position", "velocity", "angular_velocity") for axis in range(3)),
    *((field, None) for field in ("radius", "mass")),
    *((field, None) for field in ("rolling_friction", "sliding_friction")),
    ("spinning_friction_rate", None),
]
"""Fields of a ball, and a component of each field that is a vector."""

NUMBERS_OF_PHYSICS = [field for field, value in Physics() if isinstance(value, float)]


def spoilt(scene, value):
    """Yield the scene with each of its numbers replaced in turn, and the name of that number."""
    for i in (0, len(scene.balls) - 1):
        for field, axis in FIELDS:
            planted = value
            if axis is not None:
                vector = list(getattr(scene.balls[i], field) or (0.0, 0.0, 0.0))
                vector[axis] = value
                planted = tuple(vector)
            name = f"balls[{i}].{field}" + ("" if axis is None else f"[{axis}]")
            yield name, with_ball(scene, i, **{field: planted})
    for field in NUMBERS_OF_PHYSICS:
        physics = scene.physics.model_copy(update={field: value})
        yield f"physics.{field}", scene.model_copy(update={"physics": physics})
    for field in ("length", "width"):
        table = scene.table.model_copy(update={field: value})
        yield f"table.{field}", scene.model_copy(update={"table": table})
    yield "t_max", scene.model_copy(update={"t_max": value})


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("count", [3])
@pytest.mark.parametrize(
    "physics",
    [{}, {"preset": "pool"}, {"preset": "pool", "ball_impact": "mathavan2014"}],
    ids=["rolling", "sliding", "integrated"],
)
def test_each_number_of_a_scene_that_got_past_its_checks_is_refused_by_name(physics, count, value):
    others = [ball((0.5 + 0.07 * (k % 15), 0.1 + 0.07 * (k // 15))) for k in range(count - 1)]
    cue = ball((0.3, 0.3), (1.0, 0.1))
    scene = scene_of(cue, *others, table=POOL_TABLE, t_max=0.5, **physics)
    names = set()
    for name, wrong in spoilt(scene, value):
        names.add(name)
        with pytest.raises(SceneError, match="created without validation") as caught:
            simulate(wrong, record="trajectory")
        assert f"`{name}`" in str(caught.value)
    assert len(names) == 2 * len(FIELDS) + len(NUMBERS_OF_PHYSICS) + 3


def far_away(velocity, **fields):
    """Return balls in a square, 1e6 m away, hardly larger than the rounding of their positions."""
    place, rows = 1e6, 6
    radius = 1.5 * 16.0 * 2.0**-52 * 2.0 * place
    balls = []
    for k in range(rows * rows):
        i, j = k % rows, k // rows
        own = {name: value(i) for name, value in fields.items()}
        at = (place + 1.3 * i * radius, place + 1.3 * j * radius)
        balls.append(ball(at, velocity(i, j), radius=radius, **own))
    return scene_of(*balls, t_max=1.0)


OVERFULL = pytest.mark.parametrize(
    "scene",
    [
        # More pairs collide at once than possible for balls side by side: all balls move to the
        # middle.
        far_away(lambda i, j: (1e-3 * (3 - i), 1e-3 * (3 - j))),
        # More pairs stay in contact: each column decelerates more than the column behind it.
        far_away(lambda i, j: (1e-4, 0.0), rolling_friction=lambda i: 0.01 * (1 + i)),
    ],
    ids=["impacts", "resting contact"],
)
"""Valid scenes, whose balls overlap by no more than rounding."""


@OVERFULL
def test_more_contacts_than_there_is_room_for_end_the_run(scene):
    result = simulate(scene, record="events", max_events=100)
    assert result.status is Status.FAILED
    assert "more balls touch than can lie side by side" in result.reason


@OVERFULL
def test_more_contacts_than_there_is_room_for_end_a_shot_of_a_sweep(scene):
    vx, vy, _ = scene.balls[0].velocity
    batch = simulate_sweep(scene, math.hypot(vx, vy), [math.atan2(vy, vx)], max_events=100)
    assert not batch.complete.any()


# --- arguments and results


def test_an_unknown_record_is_refused():
    with pytest.raises(GhostballError, match=r"`record` must be .*got 'all'"):
        simulate(scene_of(ball((0, 0))), record="all")


@pytest.mark.parametrize("limit", ["max_events", "max_work"])
@pytest.mark.parametrize("wrong", [0, -5, 2.5, math.inf, True, "a", None, 2**63])
def test_a_limit_that_is_none_is_refused(limit, wrong):
    rule = f"`{limit}` must be a whole number from 1 to .*, got {wrong!r}"
    with pytest.raises(GhostballError, match=rule):
        simulate(scene_of(ball((0, 0))), **{limit: wrong})


def test_unsupported_physics_is_refused_by_name():
    with pytest.raises(
        UnsupportedSceneError,
        match=r"`table\.posts` must leave at most 53 obstacles on the table .* got 64\. Remove",
    ):
        simulate(scene_of(ball((0.2, 0.1), (1, 0)), table=crowded_table()))


def test_events_have_the_dtype_of_the_contract_and_counts_agree():
    scene = scene_of(ball((0.5, 0.5), (2, 0.3)), ball((1.5, 0.6)), table=POOL_TABLE)
    result = simulate(scene, record="events")
    assert result.events.dtype == EVENT_DTYPE
    kinds = result.events["kind"].tolist()
    counted = {kind: kinds.count(kind) for kind in (EventKind.BALL_BALL, EventKind.BALL_CUSHION)}
    assert min(counted.values()) > 0
    assert result.collision_counts == {kind.label: count for kind, count in counted.items()}
    assert result.work["events"] == len(result.events)
    rests = result.events["kind"] == EventKind.ROLL_TO_REST
    assert set(result.events["b"][rests].tolist()) == {-1}


def test_a_resting_scene_has_no_events_and_no_time():
    result = simulate(scene_of(ball((0.3, 0.1)), ball((0.9, 0.2))), record="events")
    assert (result.status, result.rest_time, len(result.events)) == (Status.REST, 0.0, 0)
    assert np.array_equal(result.rest_positions, result.scene.positions)


@pytest.mark.checkout
@pytest.mark.parametrize(
    "name",
    [
        "break-7",
        "pool-break-9",
        "restitution-cut",
        "elastic-gas",
        "mathavan-cut",
        "push-line",
        "air-slides",
        "air-curves",
        "flight-jump",
    ],
)
def test_a_shot_has_the_bits_of_its_baseline(name):
    """This holds compiled and interpreted, after any other run.

    A fused multiply-add, or a sum in another order, would fail here. After an intended change,
    `ghostball accept` stores the new hash.
    """
    accepted = json.loads((BASELINES / f"{name}.json").read_text(encoding="utf-8"))
    found = fingerprint(simulate(find_scene(name), record="events"))
    assert found == accepted["record"]["bits"]
