"""Tests of fixed obstacles on a table: hit at the time of the closed form, or missed.

The first tests use noses that no table has, one row each.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from more_obstacles import Play, played_among
from recorded import fingerprint
from shots import R, ball, scene_of
from side_pocket import into_side_pocket

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.running import from_scene, obstacle_rows
from ghostball.model import Ball, EventKind, Hole, Physics, Result, Scene, Status, Table, event_dict
from ghostball.model.scene.obstacles import gap_to, is_inside
from ghostball.validation.scenes.random_scenes import random_scene

MIRROR = 0.0


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Play:
    """Simulate a scene with more obstacles than its cushions."""
    return partial(played_among, monkeypatch)


def cushion_collisions(result: Result) -> list[tuple[float, int]]:
    assert result.events is not None
    kept = result.events[result.events["kind"] == EventKind.BALL_CUSHION]
    return [(float(event["t"]), int(event["b"])) for event in kept]


@pytest.mark.parametrize("slowing", [0.0, 0.02])
@pytest.mark.parametrize("offset", [0.0, 0.3, 0.9, 0.999])
def test_a_ball_bounces_off_a_circular_nose(played: Play, offset: float, slowing: float) -> None:
    """The ball moves along x and touches at the sum of the radii; its velocity is mirrored."""
    nose, speed, far = 0.05, 1.5, 0.8
    reach = R + nose
    height = offset * reach
    scene = scene_of(ball((0.0, 0.0), (speed, 0.0)), t_max=1.0, rolling_friction=slowing)
    result = played(scene, (st.DISC, far, -height, 0.0, 0.0, nose, MIRROR, 4))
    way = far - math.sqrt(reach * reach - height * height)
    a = slowing * scene.physics.gravity
    contact = 2.0 * way / (speed + math.sqrt(speed * speed - 2.0 * a * way))
    ((t, index),) = cushion_collisions(result)
    assert index == 4
    # For a grazing collision, rounding of the gap limits the accuracy of the time.
    assert t == pytest.approx(contact, rel=1e-14 / (1.0 - offset * offset))
    before = speed - a * contact
    nx, ny = (way - far) / reach, height / reach
    after = result.sample([np.nextafter(t, 2.0)]).velocities[0, 0, :2]
    along = before * nx
    want = np.array([before - 2.0 * along * nx, -2.0 * along * ny])
    assert after == pytest.approx(want, abs=1e-10)


def test_a_ball_that_passes_a_circular_nose_misses_it(played: Play) -> None:
    scene = scene_of(ball((0.0, 0.0), (1.5, 0.0)), t_max=1.0)
    near = (R + 0.05) * (1.0 + 1e-9)
    assert cushion_collisions(played(scene, (st.DISC, 0.8, near, 0.0, 0.0, 0.05, MIRROR, 4))) == []


def test_a_ball_bounces_off_a_segment_and_off_its_end(played: Play) -> None:
    wall = (st.SEGMENT, 0.5, -0.2, 0.5, 0.2, 0.0, MIRROR, 4)
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.0, t_max=1.0)
    ((t, _),) = cushion_collisions(played(scene, wall))
    assert t == pytest.approx(0.5 - R, rel=1e-15)
    beside = scene_of(ball((0.0, 0.2 + 0.5 * R), (1.0, 0.0)), rolling_friction=0.0, t_max=1.0)
    ((t, _),) = cushion_collisions(played(beside, wall))
    assert t == pytest.approx(0.5 - R * math.sqrt(0.75), rel=1e-14)


def test_a_line_aslant_is_a_row_too(played: Play) -> None:
    nx, ny = -0.6, 0.8
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.0, t_max=2.0)
    result = played(scene, (st.LINE, 0.6, 0.0, nx, ny, 0.0, MIRROR, 4))
    ((t, _),) = cushion_collisions(result)
    assert t == pytest.approx(0.6 - R / 0.6, rel=1e-15)
    velocity = result.sample([t]).velocities[0, 0, :2]
    assert velocity == pytest.approx([1.0 - 2.0 * 0.36, 2.0 * 0.48], abs=1e-15)


def test_many_balls_among_circular_noses_keep_energy_and_distance(played: Play) -> None:
    """A Sinai billiard: three balls without friction, on a table with a disc in the middle."""
    balls = [ball((0.2 + 0.2 * k, 0.15), (0.3 - 0.2 * k, 0.9), id=f"b{k}") for k in range(3)]
    scene = scene_of(*balls, table=Table(length=1.0, width=1.0), rolling_friction=0.0, t_max=20.0)
    result = played(scene, (st.DISC, 0.5, 0.55, 0.0, 0.0, 0.12, MIRROR, 4))
    assert sum(index == 4 for _, index in cushion_collisions(result)) > 5
    times = np.linspace(0.0, 20.0, 4001)
    energy = result.energy(times).total
    assert np.ptp(energy) <= 1e-12 * energy[0]
    away = np.linalg.norm(result.sample(times).positions[:, :, :2] - (0.5, 0.55), axis=2)
    assert away.min() >= (R + 0.12) * (1.0 - 1e-12)


@pytest.mark.parametrize("cushion", ["frictional", "han2005", "mathavan2010", "stronge2000"])
def test_a_bounce_has_the_coefficients_of_its_own_row(
    monkeypatch: pytest.MonkeyPatch, cushion: str
) -> None:
    """The coefficients must be those of the right cushion; all others are different."""

    def shot(restitution: float, friction: float) -> Scene:
        cue = ball((0.8, 0.4), (1.0, 0.3), angular_velocity=(3.0, -5.0, 20.0))
        return scene_of(
            cue, table=Table(length=1.0, width=1.0), t_max=0.5, motion="sliding", cushion=cushion,
            cushion_restitution=restitution, cushion_friction=friction,
        )  # fmt: skip

    wanted = simulate(shot(0.6, 0.4), record="events")
    assert cushion_collisions(wanted)[0][1] == 1
    assert wanted.collision_counts["ball-cushion"] == 1
    own, rows = obstacle_rows.coefficients_of(wanted.scene.physics), obstacle_rows.obstacles_of

    def right_one_differs(scene: Scene, *more: Any) -> Any:
        found = rows(scene, *more).copy()
        found[1, -len(own) :] = own
        return found

    monkeypatch.setattr(from_scene, "obstacles_of", right_one_differs)
    assert fingerprint(simulate(shot(0.9, 0.1), record="events")) == fingerprint(wanted)


# --- pockets, polygons and posts: closed forms, joints, and paths that are impossible

FREE = Physics(rolling_friction=0.0)


def play_on(
    table: Table | str, *balls: Ball, physics: Physics = FREE, t_max: float = 4.0
) -> Result:
    data = {"name": "shot", "table": table, "physics": physics, "balls": balls, "t_max": t_max}
    return simulate(Scene.model_validate(data), record="trajectory")


def met(result: Result) -> list[tuple[str, Any]]:
    return [(event["kind"], event["b"]) for event in map(event_dict, result.events)]


def goes_in(degrees: float, offset: float) -> bool:
    shot = into_side_pocket(degrees, offset, away=0.9, t_max=1.5)
    return ("pocketed", "bottom") in met(simulate(shot, record="events"))


@pytest.mark.parametrize(("degrees", "goes"), [(68.2915, True), (68.2925, False)])
def test_no_ball_goes_in_beyond_the_critical_angle_of_a_side_pocket(degrees: float, goes: bool):
    """Alciatore, technical proof 3.5: 68.292 degrees, from straight lines and mirrors."""
    aims = np.linspace(0.01294, 0.01300, 61)
    assert any(goes_in(degrees, float(aim)) for aim in aims) == goes


def test_a_ball_is_pocketed_where_its_centre_enters_the_hole():
    table = Table.model_validate("wpa-9ft")
    (hole,) = (one for one in table.obstacles if isinstance(one, Hole) and one.pocket == 1)
    ball = Ball(id="cue", position=(1.27, 0.6), velocity=(0.0, -1.5))
    result = play_on(table, ball, physics=Physics())
    assert met(result) == [("pocketed", "bottom")]
    edge = hole.centre[1] + hole.radius
    assert result.rest_positions[0, :2] == pytest.approx([1.27, edge], abs=1e-15)
    way, slowing = 0.6 - edge, 0.02 * 9.81
    t = 2.0 * way / (1.5 + math.sqrt(1.5**2 - 2.0 * slowing * way))
    assert result.events["t"][0] == pytest.approx(t, rel=1e-15)
    assert result.energy([2.0 * t]).total[0] == 0.0
    assert result.status is Status.REST


def test_a_ball_that_stops_in_the_jaws_stays_there():
    way = 0.6 - 0.002  # distance to just before the line of the noses
    ball = Ball(id="cue", position=(1.27, 0.6), velocity=(0.0, -math.sqrt(2 * 0.02 * 9.81 * way)))
    result = play_on("wpa-9ft", ball, physics=Physics(), t_max=60.0)
    assert met(result) == [("roll-to-rest", None)]
    assert result.rest_positions[0, 1] == pytest.approx(0.002, abs=1e-12)


def test_a_ball_that_meets_rail_and_jaw_where_they_join_has_one_contact():
    """Shots at the joint and slightly beside it each get one impulse, as from a line."""
    table = Table.model_validate("wpa-9ft")
    joint = table.obstacles[0].end[0]  # end of the bottom rail, at the jaw of the side pocket
    for aside in (0.0, 1e-17, -1e-17, 1e-12, -1e-12, 1e-9, -1e-9):
        ball = Ball(id="cue", position=(joint + aside, 0.5), velocity=(0.0, -1.0))
        result = play_on(table, ball, t_max=0.8)
        assert met(result) == [("ball-cushion", "bottom")]
        assert result.sample([0.7]).velocities[0, 0, 1] == pytest.approx(1.0, abs=1e-7)


def test_a_ball_that_glides_along_a_rail_passes_a_pocket():
    """It touches the rail, leaves it at the jaw, and continues along the next rail."""
    ball = Ball(id="cue", position=(0.6, 0.028575), velocity=(1.0, 0.0))
    result = play_on("wpa-9ft", ball, t_max=1.0)
    assert met(result) == []
    assert result.rest_positions[0, :2] == pytest.approx([1.6, 0.028575], abs=1e-15)


def test_two_balls_fall_into_one_pocket_at_one_instant():
    """Side by side, each hits the facing on its side, and then falls into the hole."""
    balls = [
        Ball(id=name, position=(1.27 + x, 0.5), velocity=(0.0, -1.0))
        for name, x in (("left", -0.034), ("right", 0.034))
    ]
    result = play_on("wpa-9ft", *balls)
    assert met(result) == [("ball-cushion", "bottom")] * 2 + [("pocketed", "bottom")] * 2
    times = result.events["t"][2:]
    assert times[0] == pytest.approx(times[1], rel=1e-14)


@pytest.mark.parametrize("aside", [0.0, 1e-9, -1e-9])
@pytest.mark.parametrize("parts", [3, 4, 5, 8, 20, 180])
def test_a_ball_along_the_bisector_of_a_corner_comes_back(parts: int, aside: float):
    """Unfolded, a ball leaves a corner of pi / n as it entered, after n bounces without loss.

    It reaches both sides simultaneously, within rounding, or one just before the other, with the
    same result.
    """
    angle = math.pi / parts
    reach, back = 0.028575 / math.sin(angle / 2.0), 0.5
    length = reach + 3.0 * back
    height = length * math.tan(angle / 2.0)
    table = Table.model_validate(
        {"vertices": [(0.0, height), (length, 0.0), (length, 2.0 * height)]}
    )
    ball = Ball(id="cue", position=(reach + back, height + aside), velocity=(-1.0, 0.0))
    physics = Physics(rolling_friction=0.0, cushion="mirror")
    result = play_on(table, ball, physics=physics, t_max=2.0 * back)
    assert result.collision_counts["ball-cushion"] == parts
    end = result.final_state
    assert end.positions[0, 0, :2] == pytest.approx([reach + back, height], abs=1e-6)
    assert end.velocities[0, 0, :2] == pytest.approx([1.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("degrees", [50.0, 77.0, 100.0, 135.0, 160.0])
def test_no_corner_takes_energy_by_itself(degrees: float):
    """If the two orders differ, the ball leaves between their directions with its initial speed."""
    angle = math.radians(degrees)
    length = 1.0
    height = length * math.tan(angle / 2.0)
    table = Table.model_validate(
        {"vertices": [(0.0, height), (length, 0.0), (length, 2.0 * height)]}
    )
    ball = Ball(id="cue", position=(0.5, height), velocity=(-1.0, 0.0))
    physics = Physics(rolling_friction=0.0, cushion="mirror")
    result = play_on(table, ball, physics=physics, t_max=0.6)
    assert result.collision_counts["ball-cushion"] >= 1
    assert np.hypot(*result.final_state.velocities[0, 0, :2]) == pytest.approx(1.0, abs=1e-12)


def test_a_polygon_that_is_a_rectangle_plays_like_one():
    corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
    ball = Ball(id="cue", position=(0.3, 0.4), velocity=(2.0, 1.3))
    physics = Physics(preset="pool")
    one = play_on(Table.model_validate({"vertices": corners}), ball, physics=physics, t_max=9.0)
    two = play_on(Table(length=2.0, width=1.0), ball, physics=physics, t_max=9.0)
    assert one.rest_positions == pytest.approx(two.rest_positions, abs=1e-12)
    assert [kind for kind, _ in met(one)] == [kind for kind, _ in met(two)]


@pytest.mark.parametrize(
    ("part", "speed", "aside", "physics"),
    [
        (0.62, 0.1, 0.0, Physics()),
        (0.62, 0.1, 0.0, Physics(cushion="restitution", cushion_restitution=0.5)),
        (0.41, 0.1, 1e-15, Physics(motion="sliding", rolling_friction_quadratic=0.0039)),
    ],
    ids=["mirror", "restitution", "quadratic"],
)
def test_a_ball_along_a_slanting_side_goes_along_it(part, speed, aside, physics):
    """A rounding of the velocity towards the side once caused endless bounces."""
    start, end = np.array([1.25, 0.0]), np.array([0.5, 1.0])
    along = (end - start) / math.hypot(*(end - start))
    off = np.array([-along[1], along[0]])
    x, y = start + part * (end - start) + 0.028575 * off
    vx, vy = speed * (along - aside * off)
    table = Table.model_validate({"vertices": [(0.0, 0.0), tuple(start), tuple(end)]})
    ball = Ball(id="cue", position=(x, y), velocity=(vx, vy))
    result = play_on(table, ball, physics=physics, t_max=0.2)
    assert result.status is Status.T_MAX
    assert result.collision_counts["ball-cushion"] <= 1
    way = result.final_state.positions[0, 0, :2] - (x, y)
    assert float(way @ off) == pytest.approx(0.0, abs=1e-15)
    assert float(way @ along) > 0.15 * speed


def test_a_ball_meets_a_corner_that_points_into_the_table_as_a_point():
    """Head on it returns; beside the centre it bounces as off a disc with its own radius."""
    shape = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
    table = Table.model_validate({"vertices": shape})
    radius, aside = 0.028575, 0.01
    direction, normal = (
        np.array([1.0, 1.0]) / math.sqrt(2.0),
        np.array([1.0, -1.0]) / math.sqrt(2.0),
    )
    place = np.array([1.0, 1.0]) - 0.5 * direction + aside * normal
    ball = Ball(id="cue", position=tuple(place), velocity=tuple(direction))
    result = play_on(table, ball, t_max=0.6)
    ((kind, _),) = met(result)
    assert kind == "ball-cushion"
    depth = math.sqrt(radius**2 - aside**2)
    assert result.events["t"][0] == pytest.approx(0.5 - depth, rel=1e-13)
    out = (aside * normal - depth * direction) / radius
    want = direction - 2.0 * (direction @ out) * out
    assert result.sample([0.55]).velocities[0, 0, :2] == pytest.approx(want, abs=1e-11)


def test_a_contact_at_a_corner_is_named_by_the_side_that_ends_there():
    """The name must not depend on which side rounding finds first."""
    shape = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
    table = Table.model_validate({"vertices": shape})
    for k in range(40):
        angle = 0.1 + 0.034 * k
        way = np.array([math.cos(angle), math.sin(angle)])
        ball = Ball(id="cue", position=tuple(np.array([1.0, 1.0]) - 0.4 * way), velocity=tuple(way))
        assert met(play_on(table, ball, t_max=0.5)) == [("ball-cushion", "side-3")]


def test_a_billiard_round_a_post_keeps_its_energy():
    table = Table.model_validate(
        {"length": 1.0, "width": 1.0, "posts": [{"centre": (0.5, 0.5), "radius": 0.1}]}
    )
    ball = Ball(id="cue", position=(0.2, 0.3), velocity=(0.9, 0.3))
    result = play_on(table, ball, t_max=60.0)
    assert any(at == "post-1" for _, at in met(result))
    assert result.energy([60.0]).total == pytest.approx(result.energy([0.0]).total, rel=1e-12)


@pytest.mark.parametrize(
    "kind", ["polygon", pytest.param("pockets", marks=pytest.mark.compiled), "posts"]
)
def test_no_ball_of_a_random_scene_gets_out_or_into_an_obstacle(kind: str):
    for number in range(40):
        scene = random_scene(number, table=kind, ball_law="frictional", air="no", quadratic="no")
        assert scene.table is not None
        result = simulate(scene, record="trajectory")
        assert result.status.complete
        times = np.union1d(np.linspace(0.0, result.rest_time, 200), result.events["t"])
        places = result.sample(times).positions
        for k, radius in enumerate(scene.radii):
            pocketed = (result.events["kind"] == EventKind.POCKETED) & (result.events["a"] == k)
            end = result.events["t"][pocketed]
            there = times <= (end[0] if len(end) else np.inf)
            x, y = places[there, k, 0], places[there, k, 1]
            assert scene.table.is_rectangle or is_inside(scene.table.outline, x, y).all()
            for one in scene.table.obstacles:
                reach = 0.0 if isinstance(one, Hole) else radius
                assert np.min(gap_to(one, x, y)) >= reach - 1e-11
