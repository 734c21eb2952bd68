"""Tests of balls in flight: landings, the end of bounces, and collisions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shots import FLIES, JUST_ABOVE, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.core.tolerances import EPS
from ghostball.model import EventKind, Hole, Phase, Result, Scene, Status, Table, event_dict
from ghostball.model.scene.obstacles import (
    FIRST_HOLE,
    Disc,
    gap_to,
    is_inside,
    obstacle_index,
    obstacle_name,
)
from ghostball.model.scene.pockets import outline_of_pockets
from ghostball.reference_adapters.returned import check_result
from ghostball.validation.scenes.random_scenes import ASPECTS, random_scene

G = 9.81


def landings(result):
    return result.events["t"][result.events["kind"] == EventKind.BALL_CLOTH]


def test_a_ball_flies_along_a_parabola_and_lands():
    spin = (3.0, -40.0, 70.0)
    scene = scene_of(ball((0, 0), (2, 0.5, 1.5), angular_velocity=spin), **FLIES)
    result = simulate(scene, record="trajectory")
    first = landings(result)[0]
    assert first == pytest.approx(2 * 1.5 / G, rel=2 * EPS)
    t = np.linspace(0, first * (1 - 1e-12), 7)
    states = result.sample(t)
    assert states.positions[:, 0, 2] == pytest.approx(R + 1.5 * t - G * t**2 / 2, abs=1e-15)
    assert states.positions[:, 0, :2] == pytest.approx(np.outer(t, [2, 0.5]), abs=1e-15)
    assert np.all(states.angular_velocities[:, 0] == spin)  # the cloth doesn't slow it in flight
    assert np.all(result.phases(t) == Phase.FLYING)
    energy = result.energy(t)
    assert energy.total == pytest.approx(energy.total[0], rel=4 * EPS)
    assert energy.height[3] > 0.0


# --- the end of bouncing, in closed form


def test_a_dropped_ball_comes_to_rest_after_its_series():
    """It ends sqrt(2 h / g)(1 + e)/(1 - e) after the release: no bounce is left out."""
    h, e = 0.1, 0.6
    scene = scene_of(ball((0, 0, R + h)), **(FLIES | {"table_restitution": e}))
    result = simulate(scene, record="trajectory")
    times = landings(result)
    assert times[0] == pytest.approx(0.14278431229270645, rel=4 * EPS)
    assert times[-1] == pytest.approx(0.57113724917082579, rel=8 * EPS)
    assert result.rest_time == pytest.approx(0.57113724917082579, rel=8 * EPS)
    ratios = np.diff(times)[1:-1] / np.diff(times)[:-2]
    assert ratios == pytest.approx(e, abs=1e-9)
    assert len(times) == 18
    assert result.rest_positions.tolist() == [[0.0, 0.0, R]]


@pytest.mark.parametrize("e", [0.0, 0.3, 0.9, 0.99])
def test_the_final_rolling_speed_is_the_same_for_any_bounces(e):
    """v0 - (2/7) u0: neither the table nor the number of bounces matters."""
    scene = scene_of(
        ball((0, 0, JUST_ABOVE), (2, 1, -0.7), angular_velocity=(10, -60, 5)),
        **(FLIES | {"table_restitution": e}),
    )
    result = simulate(scene, record="trajectory")
    assert result.status is Status.REST
    rolls = result.events["t"][result.events["kind"] == EventKind.SLIDE_TO_ROLL]
    t = max([*rolls, landings(result)[-1]])
    assert result.phases([t])[0, 0] == Phase.ROLLING
    rolling = np.array([2, 1]) - 2 / 7 * np.array([2 + R * 60, 1 + R * 10])
    assert result.sample([t]).velocities[0, 0, :2] == pytest.approx(rolling, abs=1e-12)


def test_a_table_that_returns_all_lets_a_ball_bounce_for_ever():
    scene = scene_of(ball((0, 0, R + 0.05)), t_max=20.0, **(FLIES | {"table_restitution": 1.0}))
    result = simulate(scene, record="trajectory")
    assert result.status is Status.T_MAX
    period = 2 * math.sqrt(2 * 0.05 / G)
    times = landings(result)
    assert times == pytest.approx(period * (np.arange(len(times)) + 0.5), rel=1e-13)
    energy = result.energy(np.linspace(0, 20, 50)).total
    assert energy == pytest.approx(energy[0], rel=1e-13)


# --- in space


def test_a_ball_dropped_on_another_bounces_off_and_both_come_to_rest():
    scene = scene_of(
        ball((0.001, 0.0005, 0.2)), ball((0, 0)), ball_restitution=0.9, ball_friction=0.05, **FLIES
    )
    result = simulate(scene, record="trajectory")
    assert result.status is Status.REST
    collisions = result.events[result.events["kind"] == EventKind.BALL_BALL]
    assert len(collisions) > 2
    assert np.all(result.rest_positions[:, 2] == R)
    times = np.linspace(0, result.rest_time, 3000)
    places = result.sample(times).positions
    assert np.min(np.linalg.norm(places[:, 0] - places[:, 1], axis=1)) > 2 * R * (1 - 1e-12)
    energy = result.energy(np.sort([*times, *result.events["t"]])).total
    assert np.all(np.diff(energy) <= 1e-13 * energy[0])


def test_a_ball_dropped_exactly_on_another_falls_off():
    """By symmetry no side is preferred; without a special rule the ball would bounce endlessly."""
    scene = scene_of(ball((0, 0, 0.1)), ball((0, 0)), ball_restitution=0.5, **FLIES)
    result = simulate(scene, record="events", max_events=50_000)
    assert result.status is Status.REST
    assert np.all(result.rest_positions[:, 2] == R)
    assert result.rest_positions[0, 1] == 0.0


def test_a_ball_over_an_open_side_comes_down_on_the_cloth_that_continues():
    table = Table(length=2.0, width=1.0, cushions=("left", "bottom", "top"))
    scene = scene_of(ball((1.8, 0.5), (3, 0, 1.5)), table=table, **FLIES)
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    assert EventKind.LEAVES_TABLE not in result.events["kind"]
    assert result.rest_positions[0, 0] > 2.0


# --- over pockets, posts and polygons: the rule for holes, and paths that are impossible

POOL = Table.model_validate("wpa-9ft")
SIDE = next(hole for hole in POOL.holes if hole.pocket == 1)
FACES_IT = 0.5  # distance of a ball from the bottom cushion [m]
SPEED = 2.0  # speed towards this cushion [m/s]


def thrown(
    place: tuple[float, ...], velocity: tuple[float, ...], table: Table = POOL, **physics: float
) -> Result:
    law = {"preset": "pool-coulomb", "airborne": True, **physics}
    ball = {"id": "cue", "position": place, "velocity": velocity}
    data = {"name": "thrown", "table": table, "physics": law, "balls": [ball]}
    return simulate(Scene.model_validate(data), record="trajectory")


def fallen(distance: float) -> float:
    """Return how far a ball at `SPEED` falls over a horizontal distance [m]."""
    return 0.5 * G * (distance / SPEED) ** 2


def at_side_pocket(height_there: float, distance: float, **physics: float) -> Result:
    """Throw a ball horizontally at the bottom side pocket.

    Its height is `height_there` [m] after a path of `distance` [m].
    """
    start = (SIDE.centre[0], FACES_IT, height_there + fallen(distance))
    return thrown(start, (0.0, -SPEED, 0.0), **physics)


def ends(result: Result) -> list[tuple[str, object]]:
    check_result(result, result.scene, "ghostball")
    return [(event["kind"], event["b"]) for event in map(event_dict, result.events)]


def test_a_ball_that_lands_in_a_hole_is_pocketed_there():
    distance = FACES_IT - SIDE.centre[1]
    result = at_side_pocket(R, distance)
    assert ends(result) == [("pocketed", "bottom")]
    assert result.rest_time == pytest.approx(distance / SPEED, rel=1e-12)
    assert result.rest_positions[0] == pytest.approx((*SIDE.centre, R), abs=1e-12)
    assert result.rest_positions[0, 2] == R
    assert result.energy([result.rest_time]).total == 0.0


@pytest.mark.parametrize(
    ("radii", "end"),
    [(1.399, ("pocketed", "bottom")), (1.401, ("leaves-table", "bottom-pocket"))],
)
@pytest.mark.parametrize("drag", [0.0, 1e-9])
def test_the_limit_of_height_at_the_far_edge_is_seven_fifths_of_the_radius(radii, end, drag):
    distance = FACES_IT - SIDE.centre[1] + SIDE.radius
    result = at_side_pocket(radii * R, distance, air_drag=drag)
    assert ends(result) == [end]
    assert result.rest_time == pytest.approx(distance / SPEED, rel=1e-7)
    assert result.rest_positions[0, 2] == pytest.approx(radii * R, rel=1e-6)


def test_a_ball_over_the_table_side_of_a_hole_stays_in_play_where_it_is_high():
    """Its path is a chord of the hole of a corner pocket, in front of the centre of the hole."""
    deep = {
        "corner": {"mouth": 0.16, "angle": 2.4, "jaw_radius": 0.01, "depth": 0.01, "radius": 0.08}
    }
    table = Table.model_validate({"length": 2.54, "width": 1.27, "pockets": deep})
    (hole,) = (one for one in table.holes if one.pocket == 0)
    ahead = 0.9 * hole.radius
    x, y = (centre + ahead * way for centre, way in zip(hole.centre, hole.inward, strict=True))
    along = (-hole.inward[1], hole.inward[0])
    half = math.sqrt(hole.radius**2 - ahead**2)
    back = half + 0.002
    start = (x - back * along[0], y - back * along[1])
    ways = {4.0: ("leaves-table", "left"), 1.2: ("pocketed", "bottom-left")}
    for radii, end in ways.items():  # a higher ball continues to the cushion behind
        height = radii * R + fallen(back + half)
        result = thrown((*start, height), (SPEED * along[0], SPEED * along[1], 0.0), table)
        assert ends(result)[0] == end


def test_a_ball_leaves_the_table_over_a_side_of_a_polygon_but_not_over_a_post():
    sides = Table.model_validate(
        {"vertices": [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]}
    )
    result = thrown((0.5, 1.5, 0.5), (2.0, 0.0, 0.0), sides)
    assert ends(result) == [("leaves-table", "side-4")]
    assert result.rest_positions[0, :2] == pytest.approx((1.0, 1.5))
    posts = {"length": 2.0, "width": 1.0, "posts": [{"centre": (1.0, 0.5), "radius": 0.1}]}
    result = thrown((0.5, 0.5, 0.5), (2.0, 0.0, 0.0), Table.model_validate(posts))
    first = event_dict(result.events[0])
    assert (first["kind"], first["b"]) == ("ball-cushion", "post-1")
    assert first["t"] == pytest.approx((0.5 - 0.1 - R) / 2.0, rel=1e-12)


def test_a_ball_leaves_the_table_where_it_reaches_a_jaw():
    """Fails if the ball leaves where its path exits the disc of the jaw on the far side."""
    jaw = next(one for one in POOL.obstacles if isinstance(one, Disc))
    (x, y), aside = jaw.centre, 0.004
    result = thrown((0.25, y - aside, 0.15), (-2.0, 0.0, 0.5))
    assert ends(result) == [("leaves-table", "left")]
    edge = x + math.sqrt(jaw.radius**2 - aside**2)
    assert result.rest_positions[0, :2] == pytest.approx((edge, y - aside), abs=1e-15)
    assert result.rest_time == pytest.approx((0.25 - edge) / 2.0, rel=1e-14)


def test_no_ball_leaves_a_pocket_behind_the_ends_of_its_facings():
    """The facings diverge so much that they are nearest to the hole's centre in front of it."""
    corner = {"mouth": 0.13, "angle": 1.9, "jaw_radius": 0.005, "depth": 0.03, "radius": 0.17}
    table = Table.model_validate({"length": 2.0, "width": 1.0, "pockets": {"corner": corner}})
    (hole,) = (one for one in table.holes if one.pocket == 0)
    for angle in np.linspace(0.1, 1.4, 40):
        for aside in (-0.06, -0.03, 0.0, 0.03, 0.06):
            way = (-math.cos(angle), -math.sin(angle))
            x, y = (c - 0.6 * w for c, w in zip(hole.centre, way, strict=True))
            x, y = x - aside * way[1], y + aside * way[0]
            if min(x, y) < 0.05:
                continue
            height = 0.3 + 0.5 * G * (0.8 / 4.0) ** 2
            result = thrown((x, y, height), (4.0 * way[0], 4.0 * way[1], 0.0), table)
            assert ends(result)[0][0] == "leaves-table"
            assert len(result.events) == 1


def test_the_name_of_a_pocket_flown_over_reads_back():
    index = obstacle_index("bottom-pocket")
    assert index == FIRST_HOLE + SIDE.pocket == st.FIRST_HOLE + SIDE.pocket
    assert obstacle_name(index) == "bottom-pocket"


ALOFT = tuple(how for how in ASPECTS["flight"] if how != "no")


@pytest.mark.parametrize("kind", ["polygon", "pockets", "posts"])
def test_no_ball_in_the_air_gets_out_or_into_an_obstacle(kind: str):
    for number in range(30 if COMPILED else 10):
        scene = random_scene(number, table=kind, flight=ALOFT, air="no", count="few")
        result = simulate(scene, record="trajectory")
        assert result.status.complete
        check_places(scene, result)


def check_places(scene: Scene, result: Result) -> None:
    """Check that balls are on the table, and clear of all noses, until they leave."""
    table = scene.table
    assert table is not None
    outline = table.outline
    if table.pockets is not None:
        outline = outline_of_pockets(table.length, table.width, table.pockets, arc=200)
    times = np.union1d(np.linspace(0.0, result.rest_time, 200), result.events["t"])
    places = result.sample(times).positions
    left = np.isin(result.events["kind"], (EventKind.POCKETED, EventKind.LEAVES_TABLE))
    for k, radius in enumerate(scene.radii):
        end = result.events["t"][left & (result.events["a"] == k)]
        x, y, z = places[times < (end[0] if len(end) else np.inf), k].T
        in_hole = np.zeros(len(x), dtype=np.bool_)
        for one in table.obstacles:
            gap = gap_to(one, x, y)
            if isinstance(one, Hole):
                in_hole |= gap <= 0.0
                continue
            is_post = isinstance(one, Disc) and one.inward is None
            away = gap if is_post else np.hypot(gap, z - scene.physics.cushion_height)
            assert np.min(away, initial=np.inf) > radius - 1e-8
        assert np.all(z[in_hole] > radius)
        assert table.is_rectangle or np.all(is_inside(outline, x, y) | in_hole)
