"""Tables in scenes: presets, polygons and posts, written and read."""

from __future__ import annotations

import math

import pytest
from mpmath import hypot, mpf, workdps
from refusals import refusal_of

from ghostball.model import (
    CUSHIONS,
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    Ball,
    Disc,
    Hole,
    Physics,
    Scene,
    SceneError,
    Segment,
    Table,
)

L_SHAPE = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0))


def scene_on(table: Table | str, **fields: object) -> Scene:
    place = {"id": "cue", "position": (0.5, 0.5), "velocity": (1.0, 0.3)}
    return Scene.model_validate({"name": "on-table", "table": table, "balls": [place], **fields})


@pytest.mark.parametrize("name", Table.PRESETS)
def test_the_name_of_a_preset_stands_for_its_table(name):
    scene = Scene.loads(
        f'schema = 1\nname = "a"\ntable = "{name}"\n[[balls]]\nid = "cue"\nposition = [0.5, 0.5]\n'
    )
    assert scene.table == Table(preset=name)
    assert (scene.table.length, scene.table.width) == (
        Table.PRESETS[name]["length"],
        Table.PRESETS[name]["width"],
    )
    assert scene.table.is_rectangle == ("pockets" not in Table.PRESETS[name])


@pytest.mark.parametrize(
    "table",
    [
        *(Table(preset=name) for name in Table.PRESETS),
        Table(preset="wpa-9ft", length=2.2),
        Table(preset="wpa-9ft", pockets={"side": Table.PRESETS["bar-7ft"]["pockets"]["side"]}),
        Table(vertices=L_SHAPE),
        Table(length=2.0, width=1.0, posts=[{"centre": (1.5, 0.5), "radius": 0.05}]),
        Table(length=2.0, width=1.0, cushions=("left",)),
    ],
    ids=repr,
)
def test_a_table_is_written_and_read(table, tmp_path):
    scene = scene_on(table)
    scene.save(tmp_path / "scene.toml")
    assert Scene.load(tmp_path / "scene.toml") == scene
    assert Scene.model_validate_json(scene.model_dump_json(by_alias=True)) == scene


def test_what_a_plain_rectangle_says_is_as_it_was():
    assert Table(length=2.0, width=1.0).model_dump() == {
        "length": 2.0,
        "width": 1.0,
        "cushions": ("left", "right", "bottom", "top"),
    }


def test_a_pool_table_has_six_rails_twelve_jaws_twelve_facings_and_six_holes():
    obstacles = Table(preset="wpa-9ft").obstacles
    assert [type(one) for one in obstacles[:6]] == [Segment] * 6
    assert [type(one) for one in obstacles[6:30]] == [Disc, Segment] * 12
    assert [one.pocket for one in obstacles[30:] if isinstance(one, Hole)] == list(range(6))


def test_a_polygon_has_its_size_and_a_side_for_each_two_vertices():
    table = Table(vertices=L_SHAPE)
    assert (table.length, table.width, table.sides) == (2.0, 2.0, ())
    assert [(one.start, one.end) for one in table.obstacles] == list(
        zip(L_SHAPE, (*L_SHAPE[1:], L_SHAPE[0]), strict=True)
    )


@pytest.mark.parametrize(
    ("position", "tells"),
    [
        ((0.02, 0.3), ("at least the radius", '"left"')),
        ((-0.2, 0.3), ("inside the table",)),
        ((0.01, 0.01), ("hole", '"bottom-left"')),
        ((1.27, -0.05), ("hole", '"bottom"')),
        ((1.22, 0.0), ("at least the radius", '"bottom"')),
        ((3.0, 3.0), ("inside the table",)),
    ],
)
def test_a_ball_that_begins_beyond_a_rail_or_in_a_jaw_or_a_hole_is_refused(position, tells):
    ball = {"id": "cue", "position": position}
    message = refusal_of(lambda: Scene(name="a", table="wpa-9ft", balls=[ball]))
    assert all(tell in message for tell in ("`balls[0].position", *tells))


def test_a_ball_may_begin_in_the_mouth_of_a_pocket():
    Scene(name="a", table="wpa-9ft", balls=[{"id": "cue", "position": (1.27, 0.001)}])


@pytest.mark.parametrize(
    ("position", "tells"),
    [((1.5, 1.5), "inside the table"), ((0.99, 1.01), '"side-3"'), ((0.01, 1.0), '"side-6"')],
)
def test_a_ball_that_begins_outside_of_a_polygon_or_in_a_side_is_refused(position, tells):
    with pytest.raises(SceneError, match=tells):
        Scene(name="a", table=Table(vertices=L_SHAPE), balls=[Ball(id="cue", position=position)])


def test_a_ball_that_begins_in_a_post_is_refused():
    table = Table(length=2.0, width=1.0, posts=[{"centre": (0.5, 0.5), "radius": 0.05}])
    with pytest.raises(SceneError, match='"post-1", a post around'):
        scene_on(table)


@pytest.mark.parametrize(
    ("obstacle", "place", "normal", "gap"),
    [
        (0, (0.3, 0.6), (1.0, 0.0), 0.3),  # the nose of the left cushion
        (2, (0.6, 0.4), (0.0, 1.0), 0.4),
        (65536, (1.5, 0.7), (0.0, 1.0), 0.15),  # the post
    ],
)
@pytest.mark.parametrize("pockets", [None, Table.PRESETS["wpa-9ft"]["pockets"]])
def test_which_way_an_obstacle_is_and_how_far(pockets, obstacle, place, normal, gap):
    posts = [{"centre": (1.5, 0.5), "radius": 0.05}]
    table = Table(length=2.54, width=1.27, pockets=pockets, posts=posts)
    found, away = table.facing(obstacle, *place)
    assert found == pytest.approx(normal, abs=1e-15)
    assert away == pytest.approx(gap, abs=1e-15)


@pytest.mark.parametrize("name", ["wpa-9ft", "snooker-12ft"])
def test_a_drawn_jaw_is_round_and_joins_nose_and_facing(name):
    table = Table.model_validate(name)
    jaws = [one for one in table.obstacles if isinstance(one, Disc)]
    assert len(table.drawn_outline) == len(table.outline) + 12 * 8
    near = [
        min(abs(math.dist(point, jaw.centre) - jaw.radius) for jaw in jaws)
        for point in table.drawn_outline
    ]
    assert sum(distance < 6e-14 for distance in near) >= 12 * 9


@pytest.mark.parametrize("name", [name for name, one in Table.PRESETS.items() if "pockets" in one])
def test_no_jaw_sticks_out_past_its_nose_or_its_facing(name):
    """Fails if rounding moves a jaw towards the cloth, where a ball along the rail would hit it."""
    table = Table.model_validate(name)
    jaws = [one for one in table.obstacles if isinstance(one, Disc)]
    straight = [one for one in table.obstacles if isinstance(one, Segment)]
    assert len(jaws) == 12
    for jaw in jaws:
        near = [
            one
            for one in straight
            if min(math.dist(jaw.centre, end) for end in (one.start, one.end)) < jaw.radius + 1e-9
        ]
        assert len(near) == 2  # its nose and its facing
        for one in near:
            stands_back = -float(_away(one, jaw.centre) + mpf(jaw.radius))
            assert 2e-14 < stands_back < 5e-14


def _away(one: Segment, place: tuple[float, float]) -> mpf:
    """Return the distance of a place in front of a segment's line, in 40 digits [m]."""
    with workdps(40):
        (ax, ay), (bx, by), (x, y) = (map(mpf, point) for point in (one.start, one.end, place))
        dx, dy = bx - ax, by - ay
        return (dx * (y - ay) - dy * (x - ax)) / hypot(dx, dy)


class TestTheBallsOfAPreset:
    """Preset, radius [m] and mass [kg]."""

    OWN = pytest.mark.parametrize(
        ("preset", "radius", "mass"),
        [
            ("carom-10ft", 0.03075, 0.21),
            ("snooker-12ft", 0.02625, 0.1406),
            ("wpa-9ft", POOL_BALL_RADIUS, POOL_BALL_MASS),
        ],
    )

    @OWN
    @pytest.mark.parametrize(
        "table_of",
        [
            lambda preset: preset,
            lambda preset: {"preset": preset, "length": 2.6},
            lambda preset: Table(preset=preset),
        ],
        ids=["name", "fields", "table"],
    )
    @pytest.mark.parametrize(
        "ball",
        [{"id": "a", "position": (0.5, 0.5)}, Ball(id="a", position=(0.5, 0.5))],
        ids=["fields", "ball"],
    )
    def test_balls_without_a_size_have_that_of_the_table(
        self, ball, table_of, preset, radius, mass, tmp_path
    ):
        scene = Scene(name="a", table=table_of(preset), balls=(b for b in [ball]))
        (found,) = scene.balls
        assert (found.radius, found.mass, found.position) == (radius, mass, (0.5, 0.5, radius))
        scene.save(tmp_path / "scene.toml")
        assert "radius" not in (tmp_path / "scene.toml").read_text()
        assert Scene.load(tmp_path / "scene.toml") == scene
        assert Scene.model_validate_json(scene.model_dump_json(by_alias=True)) == scene
        assert Scene.model_validate(scene) == scene

    @OWN
    def test_arrays_without_a_size_have_that_of_the_table(self, preset, radius, mass):
        scene = Scene.from_arrays([[0.5, 0.5], [0.8, 0.5]], name="a", table=preset)
        assert (scene.radii.tolist(), scene.masses.tolist()) == ([radius] * 2, [mass] * 2)

    @OWN
    def test_a_ball_that_is_struck_moves_as_one_of_the_table(self, preset, radius, mass):
        struck = {"id": "a", "position": (0.5, 0.5), "strike": {"speed": 2.0, "direction": 0.3}}
        own = {**struck, "radius": radius, "mass": mass}
        fields = {"name": "a", "table": preset, "physics": {"motion": "sliding"}}
        expected = Scene.model_validate({**fields, "balls": [own]})
        for ball in (struck, Ball.model_validate(struck)):
            scene = Scene.model_validate({**fields, "balls": [ball]})
            assert scene == expected
            assert scene.without_strikes().velocities.tolist() == scene.velocities.tolist()

    @pytest.mark.parametrize("table", [None, {"length": 2.0, "width": 1.0}])
    @pytest.mark.parametrize(("physics", "radius"), [("carom", 0.03075), ("snooker", 0.02625)])
    def test_without_a_standard_table_balls_are_those_of_the_physics(
        self, physics, radius, table, tmp_path
    ):
        fields = {"name": "a", "table": table, "balls": [Ball(id="a", position=(0.5, 0.5))]}
        scene = Scene(**fields, physics={"preset": physics})
        assert scene == Scene(**fields, physics=Physics(preset=physics))
        assert (scene.balls[0].radius, scene.balls[0].position) == (radius, (0.5, 0.5, radius))
        scene.save(tmp_path / "scene.toml")
        assert "radius" not in (tmp_path / "scene.toml").read_text()
        assert Scene.load(tmp_path / "scene.toml") == scene

    def test_table_and_physics_of_different_games_need_sizes(self, tmp_path):
        fields = {"name": "a", "table": "wpa-9ft", "physics": Physics(preset="snooker")}
        place = {"id": "a", "position": (0.5, 0.5)}
        for ball in (place, Ball(**place), {**place, "radius": 0.03}):
            missing = "mass" if "radius" in ball else "radius"
            expected = rf'`balls\[0\]\.{missing}` must be given, because the table "wpa-9ft" and'
            with pytest.raises(SceneError, match=expected):
                Scene(**fields, balls=[ball])
        with pytest.raises(SceneError, match=r"^`balls\[0\]` must be a table of fields, got 1\.$"):
            Scene(**fields, balls=[1])
        scene = Scene(**fields, balls=[Ball(**place, radius=POOL_BALL_RADIUS, mass=0.1406)])
        scene.save(tmp_path / "scene.toml")
        assert Scene.load(tmp_path / "scene.toml") == scene

    def test_a_size_that_is_given_stays(self, tmp_path):
        ball = {"id": "a", "position": (0.5, 0.5), "radius": POOL_BALL_RADIUS, "mass": 0.2}
        for one in (ball, Ball.model_validate(ball)):
            scene = Scene.model_validate({"name": "a", "table": "carom-10ft", "balls": [one]})
            assert (scene.balls[0].radius, scene.balls[0].mass) == (POOL_BALL_RADIUS, 0.2)
            scene.save(tmp_path / "scene.toml")
            assert Scene.load(tmp_path / "scene.toml") == scene

    def test_a_ball_in_the_air_stays_where_it_is(self):
        physics = {"motion": "sliding", "airborne": True}
        ball = Ball(id="a", position=(0.5, 0.5, 0.1))
        scene = Scene(name="a", table="carom-10ft", physics=physics, balls=[ball])
        assert scene.balls[0].position == (0.5, 0.5, 0.1)


# --- the sides of a table: position and inward normal of each cushion

TABLE = Table(length=2.0, width=1.0)


@pytest.mark.parametrize(
    ("name", "nearest"),
    [("left", (0.0, 0.25)), ("right", (2.0, 0.25)), ("bottom", (0.5, 0.0)), ("top", (0.5, 1.0))],
)
def test_a_side_knows_where_it_is_and_which_way_is_in(name, nearest):
    """Fails if a normal points outward, or if a point is on another line."""
    side = TABLE.sides[CUSHIONS.index(name)]
    assert (side.name, side.cushion) == (name, CUSHIONS.index(name))
    assert side.distance(*nearest) == 0.0
    x, y = nearest
    assert side.distance(x + 0.125 * side.normal[0], y + 0.125 * side.normal[1]) == 0.125
    assert side.length == (1.0 if side.across == 0 else 2.0)
    assert all(side.distance(*end) == 0.0 for end in side.ends())
    assert all(side.distance(*end) == -0.25 for end in side.ends(beyond=0.5, outward=0.25))


def test_an_open_side_is_none():
    assert [side.name for side in Table(length=2.0, width=1.0, cushions=("top",)).sides] == ["top"]
