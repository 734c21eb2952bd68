"""A shot may start from any rest state or intermediate state, on every table, with all physics."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refusal_of
from shots import FLIES, POOL_TABLE, R, ball, result_of, scene_of

from ghostball.engine import simulate, simulate_many
from ghostball.model import (
    Disc,
    EventKind,
    GhostballError,
    Hole,
    Physics,
    SampledTrajectory,
    Scene,
    SceneError,
    Status,
    Strike,
    Table,
    initial_state,
)
from ghostball.model.events import LEAVING_KINDS
from ghostball.model.rounding import CONTACT_TOLERANCE
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import random_scene

POSTS = [{"centre": (0.5, 0.5), "radius": 0.05}, {"centre": (1.6, 0.3), "radius": 0.02}]
CORNERS = [(0.0, 0.0), (2.0, 0.0), (2.3, 0.7), (1.2, 0.6), (1.0, 1.5), (0.0, 1.2)]
TABLES = {
    "rails": POOL_TABLE,
    "jaws": Table(preset="wpa-9ft"),
    "posts": Table.model_validate({"vertices": CORNERS, "posts": POSTS}),
}


def places_touching(chance, table):
    """Return the centres of 3 to 6 touching balls; the first one also touches an obstacle."""
    obstacles = [*table.sides, *(one for one in table.obstacles if not isinstance(one, Hole))]
    while True:
        place = chance.uniform((0.1, 0.1), (table.length - 0.1, table.width - 0.1))
        one = obstacles[chance.integers(len(obstacles))]
        index = one.cushion if one in table.sides else one.obstacle
        normal, gap = table.facing(index, *place)
        centres = [place + (R - gap) * np.array(normal)]
        for _ in range(chance.integers(2, 6)):
            angle = chance.integers(12) * math.pi / 6.0
            step = 2.0 * R * np.array([math.cos(angle), math.sin(angle)])
            centres.append(centres[chance.integers(len(centres))] + step)
        try:
            return Scene.from_arrays(centres, name="cluster", table=table, radii=R, masses=0.17)
        except SceneError:
            continue


def chain(seed, table, preset, count):
    """Simulate `count` shots, each from the rest state of the previous one; yield their results."""
    chance = np.random.default_rng(seed)
    physics = Physics(preset=preset)
    scene = None
    for shot in range(count):
        if scene is None or shot % 20 == 0 or len(scene.balls) < 2:
            cluster = places_touching(chance, table)
            scene = Scene(name="cluster", balls=cluster.balls, table=table, physics=physics)
        one, other = chance.choice(len(scene.balls), 2, replace=False)
        places = scene.positions[:, :2]
        angle = math.atan2(*(places[other] - places[one])[::-1]) + chance.normal(0.0, 0.3)
        speed = chance.choice([0.03, 0.1, 0.3, 2.0])
        change = {"velocity": (speed * math.cos(angle), speed * math.sin(angle))}
        if physics.motion == "sliding":
            change["angular_velocity"] = tuple(chance.normal(0.0, 30.0, 3))
        started = with_changes(scene, {scene.balls[one].id: change})
        result = simulate(started)
        yield result
        scene = None if np.all(result.gone) else Scene.after(result)


def with_changes(scene, changes):
    """Return a scene of resting balls with changes of some balls."""
    return Scene.after(result_of(scene), name=scene.name, changes=changes)


@pytest.mark.compiled
@pytest.mark.parametrize("preset", Physics.PRESETS)
def test_every_rest_state_is_the_start_of_the_next_shot(preset):
    for table in TABLES.values():
        statuses = [result.status for result in chain(1, table, preset, 70)]
        assert statuses == [Status.REST] * 70


def test_a_slow_hit_of_a_pool_ball_ends_where_the_next_shot_may_begin():
    scene = scene_of(
        ball(
            (1.0371763566661123, 0.6457923359240355), (-0.09256955606770374, -0.12444762140057168)
        ),
        ball((1.0, 0.6)),
        preset="pool",
        ball_restitution=0.3,
        ball_friction=0.2,
    )
    result = simulate(scene)
    (one, other) = result.rest_positions
    assert 2.0 * R - math.dist(one, other) > 1e-14
    assert Scene.after(result).positions.tolist() == result.rest_positions.tolist()


@pytest.mark.compiled
@pytest.mark.parametrize(
    "numbers", [range(60, 110), pytest.param(range(110, 1000), marks=pytest.mark.slow)], ids=repr
)
def test_wherever_balls_of_a_random_scene_are_another_may_begin(numbers):
    """For all physics, sizes and masses, on the cloth and in the air, also at events."""
    for number in numbers:
        result = simulate(random_scene(number), record="events", max_events=20_000)
        empty = math.inf  # from this time on, no ball is left
        if np.all(result.gone):
            empty = result.events["t"][np.isin(result.events["kind"], LEAVING_KINDS)].max()
        elif result.status is Status.REST:
            Scene.after(result)
        chance = np.random.default_rng(number)
        events = chance.choice(np.append(0.0, result.events["t"]), 5)
        before = np.nextafter(events[events > 0.0], 0.0)
        for t in [*chance.uniform(0.0, result.rest_time, 3), *events, *before]:
            if t < empty:
                result.at(t)


PUSHED_IN = 0.99 * CONTACT_TOLERANCE * 2.0 * R
"""An overlap [m] that a resting contact may have."""


def starts(overlap):
    """Yield scenes with a ball that overlaps a body by `overlap` [m], and the expected motion."""
    sliding = {"preset": "pool"}
    walls = {
        "rail": (POOL_TABLE, (0.7, R - overlap), (0.0, 1.0)),
        "jaw": (TABLES["jaws"], *beside_jaw(overlap)),
        "post": (TABLES["posts"], (0.5, 0.55 + R - overlap), (0.0, 1.0)),
        "side": (TABLES["posts"], (0.3, R - overlap), (0.0, 1.0)),
        "corner": (TABLES["posts"], (1.2, 0.6 - R + overlap), (0.0, -1.0)),
    }
    for table, (x, y), (nx, ny) in walls.values():
        for across, along in ((-0.5, 0.2), (0.5, 0.2), (0.0, 0.4)):
            velocity = (across * nx - along * ny, across * ny + along * nx)
            for physics in ({}, sliding):
                yield scene_of(ball((x, y), velocity), table=table, **physics)
    pair = [(0.7, 0.6), (0.7 + 2.0 * R - overlap, 0.6)]
    for speed in (-0.5, 0.0, 0.5):
        for physics in ({}, sliding, FLIES):
            still = ball(pair[1])
            yield scene_of(ball(pair[0], (speed, 0.1)), still, **physics)
            hit = ball((0.5, 0.61), (1.0, 0.0))
            yield scene_of(ball(pair[0]), still, hit, table=POOL_TABLE, **physics)


def beside_jaw(overlap):
    """Return the centre of a ball that overlaps a jaw of the left cushion, and the normal there."""
    jaw = next(one for one in TABLES["jaws"].obstacles if isinstance(one, Disc))
    # The normal of the nose is (1, 0), that of the facing 38 degrees below it.
    normal = (math.cos(math.pi / 8.0), -math.sin(math.pi / 8.0))
    away = R + jaw.radius - overlap
    return (jaw.centre[0] + away * normal[0], jaw.centre[1] + away * normal[1]), normal


@pytest.mark.compiled
def test_a_start_that_overlaps_by_the_tolerance_moves_like_one_that_touches():
    for overlapping, touching in zip(starts(PUSHED_IN), starts(0.0), strict=True):
        one, other = simulate(overlapping, record="events"), simulate(touching, record="events")
        assert one.status is Status.REST
        assert one.events[["kind", "a", "b"]].tolist() == other.events[["kind", "a", "b"]].tolist()
        assert one.rest_positions == pytest.approx(other.rest_positions, abs=1e-10)


@pytest.mark.parametrize("overlap", [1.1 * PUSHED_IN, 1e-9])
def test_a_larger_overlap_is_refused(overlap):
    pair = ball((0.7, 0.6)), ball((0.7 + 2.0 * R - overlap, 0.6))
    assert "overlap by" in refusal_of(lambda: scene_of(*pair))
    for table, place, says in (
        (POOL_TABLE, (0.7, R - overlap), "beyond the bottom cushion"),
        (TABLES["jaws"], beside_jaw(overlap)[0], '"left", a jaw'),
        (TABLES["posts"], (0.5, 0.55 + R - overlap), '"post-1"'),
        (TABLES["posts"], (0.3, R - overlap), '"side-1"'),
    ):
        assert says in refusal_of(
            lambda table=table, place=place: scene_of(ball(place), table=table)
        )


class TestTheNextShot:
    def test_pocketed_balls_are_left_out_and_the_others_keep_what_they_are(self):
        scene = find_scene("pocket-break-9")
        for record in ("rest", "events"):
            result = simulate(scene, record=record)
            after = Scene.after(result)
            assert result.gone.tolist() == [False] * 9 + [True]
            assert [b.id for b in after.balls] == [b.id for b in scene.balls[:9]]
            assert after.positions.tolist() == result.rest_positions[~result.gone].tolist()
            assert not np.any(after.velocities)
            assert (after.table, after.physics, after.t_max) == (
                scene.table,
                scene.physics,
                scene.t_max,
            )
            assert (after.title, after.tags) == ("", ())

    def test_a_ball_keeps_its_own_size_mass_and_frictions(self):
        own = {"radius": 0.02, "mass": 0.1, "rolling_friction": 0.03, "sliding_friction": 0.1}
        scene = scene_of(ball((0.0, 0.0), (0.3, 0.0), **own), ball((1.0, 1.0)), preset="pool")
        after = Scene.after(simulate(scene))
        assert {name: getattr(after.balls[0], name) for name in own} == own
        assert after.balls[1].rolling_friction is None

    @pytest.mark.parametrize("record", ["rest", "events"])
    @pytest.mark.parametrize(
        ("name", "gone_ids"),
        [("flight-leaves", ["leaves"]), ("pocket-jump", ["object"]), ("pocket-draw", ["object"])],
    )
    def test_balls_that_left_the_table_are_gone(self, name, gone_ids, record):
        scene = find_scene(name)
        result = simulate(scene, record=record)
        assert [b.id for b, g in zip(scene.balls, result.gone, strict=True) if g] == gone_ids
        left = [b.id for b in scene.balls if b.id not in gone_ids]
        assert [b.id for b in Scene.after(result).balls] == left

    @pytest.mark.parametrize(
        ("name", "following"),
        [
            ("break", "break.2"),
            ("break.2", "break.3"),
            ("break-7", "break-7.2"),
            ("v1.0-a", "v1.0-a.2"),
            ("a" * 64, "a" * 62 + ".2"),
        ],
    )
    def test_its_name_counts_the_shots(self, name, following):
        scene = Scene(name=name, balls=[{"id": "a", "position": (0, 0)}])
        assert Scene.after(result_of(scene)).name == following
        assert Scene.after(result_of(scene), name="other").name == "other"

    def test_a_ball_is_struck_and_another_put_back(self, tmp_path):
        scene = find_scene("pocket-draw")
        result = simulate(scene)
        strike = Strike(speed=1.0, direction=0.3)
        changes = {"cue": {"strike": strike}, "object": {"position": (0.6, 0.6)}}
        after = Scene.after(result, changes=changes, title="Again")
        assert after.title == "Again"
        assert after.balls[0].strike == strike
        assert after.balls[1].position == (0.6, 0.6, after.balls[1].radius)
        after.save(tmp_path / "scene.toml")
        assert Scene.load(tmp_path / "scene.toml") == after
        assert Scene.model_validate_json(after.model_dump_json(by_alias=True)) == after

    @pytest.mark.parametrize(
        ("changes", "tells"),
        [
            ({"cu": {}}, ("`changes`", "'cu'", 'Did you mean "cue"?')),
            ({"zzz": {}}, ("`changes`", "Balls: cue, object")),
            ({"object": {"velocity": (1, 0)}}, ('`changes["object"]`', "`position`", "pocketed")),
            ({"cue": {"position": (9, 9)}}, ("`balls[0].position`", "inside the table")),
            ({"cue": {"spede": 1}}, ("`balls[0].spede`",)),
            *(
                (wrong, ("`changes`", "ball ids", "Give {"))
                for wrong in (5, [("cue", {})], {"cue": 5}, {"cue": [("velocity", (1, 0))]})
            ),
        ],
    )
    def test_a_change_that_cannot_be_is_refused(self, changes, tells):
        result = simulate(find_scene("pocket-draw"))
        message = refusal_of(lambda: Scene.after(result, changes=changes))
        assert all(tell in message for tell in tells), message

    def test_what_is_no_result_is_refused(self):
        for wrong in (5, None, simulate_many([find_scene("stop")])):
            message = refusal_of(lambda wrong=wrong: Scene.after(wrong))
            assert f"`result` must be a Result, got {type(wrong).__name__}" in message

    def test_balls_that_still_move_are_refused(self):
        result = simulate(scene_of(ball((0, 0), (1, 0)), t_max=0.5))
        message = refusal_of(lambda: Scene.after(result))
        assert "must be at rest" in message
        assert "T_MAX" in message

    def test_a_table_without_balls_is_refused(self):
        table = TABLES["jaws"]
        scene = scene_of(ball((0.3, 0.3), (-1.0, -1.0)), table=table)
        assert "none is left on the table" in refusal_of(lambda: Scene.after(simulate(scene)))


def test_balls_that_another_engine_lets_overlap_are_refused_with_the_overlap():
    scene = scene_of(ball((0.5, 0.5), id="cue"), ball((0.6, 0.5), id="eight"))
    state = initial_state(scene)
    state.positions[0, 1, 0] = 0.5 + 2.0 * R - 1e-6
    for make in (
        lambda: Scene.after(result_of(scene, final_state=state)),
        lambda: result_of(scene, trajectory=SampledTrajectory(np.zeros(1), *state)).at(0.0),
    ):
        message = refusal_of(make)
        for tell in ("engine `toy`", '`balls[0]` ("cue")', '("eight")', "by 1e-06 m", "Move one"):
            assert tell in message


def test_a_rest_state_of_another_engine_without_overlap_is_accepted():
    scene = scene_of(ball((0.5, 0.5)), ball((0.6, 0.5)))
    state = initial_state(scene)
    state.positions[0, :, 2] += 1e-5  # in a 3D engine, balls may sink in or hover
    assert Scene.after(result_of(scene, final_state=state)).positions.tolist() == (
        scene.positions.tolist()
    )


CONTINUED = dict.fromkeys(
    (
        *("break-7", "draw-shot", "english-running", "mathavan-cut", "moving-moving", "push"),
        *("three-cushions", "pocket-draw", "pocket-rattle", "flight-bounces", "flight-jump"),
        "air-rolls",
    ),
    1e-11,
)
"""Scenes, and the largest error of rest positions after a continuation [m]."""

CONTINUED["push"] = 1e-7
"""Each step of a resting contact errs by 1.5e-8 of the speed, and the steps differ."""

CONTINUED["flight-bounces"] = 1e-3
"""The vertical speed of bounces lower than 3e-9 m isn't known, up to 2.4e-4 m/s."""


@pytest.mark.compiled
@pytest.mark.parametrize("name", CONTINUED)
def test_a_shot_continued_at_any_moment_comes_to_the_same_rest(name):
    """At random times, at events, and just before events."""
    scene = find_scene(name)
    result = simulate(scene, record="events")
    chance = np.random.default_rng(1)
    events = chance.choice(result.events["t"], 8)
    before = np.nextafter(events[events > 0.0], 0.0)
    for t in [*chance.uniform(0.0, result.rest_time, 10), *events, *before]:
        later = result.at(t)
        ids = [b.id for b in later.balls]
        kept = [i for i, b in enumerate(scene.balls) if b.id in ids]
        again = simulate(later)
        off = np.abs(again.rest_positions - result.rest_positions[kept])
        assert off.max() <= CONTINUED[name]
        assert again.status is result.status


class TestTheSceneOfAMoment:
    def test_the_scene_has_the_states_of_its_moment(self, tmp_path):
        result = simulate(find_scene("flight-jump"), record="events")
        t = 0.3 * result.rest_time
        later, state = result.at(t), result.sample(t)
        assert later.positions.tolist() == state.positions[0].tolist()
        assert later.velocities.tolist() == state.velocities[0].tolist()
        assert later.angular_velocities.tolist() == state.angular_velocities[0].tolist()
        assert later.name == "flight-jump"
        later.save(tmp_path / "scene.toml")
        assert Scene.load(tmp_path / "scene.toml") == later
        assert Scene.model_validate_json(later.model_dump_json(by_alias=True)) == later

    def test_a_ball_is_left_out_once_it_is_pocketed(self):
        result = simulate(find_scene("pocket-draw"), record="events")
        pocketed = result.events["t"][result.events["kind"] == EventKind.POCKETED][0]
        assert len(result.at(np.nextafter(pocketed, 0.0)).balls) == 2
        assert [b.id for b in result.at(pocketed).balls] == ["cue"]

    def test_a_ball_that_just_lands_is_still_in_the_air(self):
        scene = scene_of(ball((0, 0, 0.1), (1.0, 0.0)), **FLIES)
        result = simulate(scene, record="events")
        landing = result.events["t"][result.events["kind"] == EventKind.BALL_CLOTH][0]
        later = result.at(np.nextafter(landing, 0.0))
        assert later.balls[0].velocity[2] < 0.0
        assert later.balls[0].position[2] == pytest.approx(R, abs=1e-15)
        assert simulate(later).rest_positions == pytest.approx(result.rest_positions, abs=1e-12)

    def test_the_time_that_is_left_is_its_own(self):
        result = simulate(scene_of(ball((0, 0), (1, 0)), t_max=0.5), record="events")
        assert result.at(0.2).t_max == 0.5 - 0.2
        assert result.at(0.5).t_max == 0.5
        with pytest.raises(GhostballError, match=r"at most 0\.5 s.* got 0\.6 s"):
            result.at(0.6)

    @pytest.mark.parametrize("t", [-1.0, math.nan, [0.1, 0.2], []])
    def test_a_time_is_one_number_from_0(self, t):
        result = simulate(scene_of(ball((0, 0), (1, 0))), record="events")
        with pytest.raises(GhostballError, match="must be"):
            result.at(t)

    def test_later_than_the_end_balls_rest(self):
        result = simulate(scene_of(ball((0, 0), (1, 0))), record="events")
        assert result.at(1e3).positions.tolist() == result.rest_positions.tolist()

    def test_an_engine_without_events_is_asked_where_balls_are(self):
        scene = find_scene("pocket-draw")
        result = replace(simulate(scene, record="events"), events=None)
        assert result.gone.tolist() == [False, True]
