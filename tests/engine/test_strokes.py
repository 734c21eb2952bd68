"""Tests of strokes as arrays: each shot is bit-identical to that of the scene with its strike."""

import math
import random
from itertools import product

import numpy as np
import pytest
from batches import assert_same
from shots import FLIES, ball, scene_of

from ghostball.engine import DrawnStrokes, Strokes, simulate, simulate_many, simulate_starts
from ghostball.model import Ball, GhostballError, Scene, SceneError, Strike, Table
from ghostball.model.scene.strike import Aims, are_valid

POCKET_TABLE = Table.model_validate("wpa-9ft")
FIELDS = Aims._fields


def layout(strike: Strike | None = None, **physics) -> Scene:
    cue = {"position": (0.6, 0.635), "strike": strike, "id": "cue", "radius": 0.028, "mass": 0.16}
    others = (ball((1.8, 0.9)), ball((1.4, 0.4)))
    pool = physics or {"preset": "pool"}
    return scene_of(cue, *others, table=POCKET_TABLE, t_max=20.0, **pool)


def moved(scene: Scene, strike: Strike, places: np.ndarray | None = None) -> Scene:
    """Return the scene with another strike of ball 0, and other places of its balls."""
    balls = [{name: getattr(one, name) for name in ("id", "radius", "mass")} for one in scene.balls]
    places = scene.positions if places is None else places
    for fields, place in zip(balls, places.tolist(), strict=True):
        fields["position"] = tuple(place[:2])
    balls[0]["strike"] = strike
    return Scene(**{**dict(scene), "balls": [Ball(**fields) for fields in balls]})


def random_strokes(seed: int, k: int) -> dict[str, np.ndarray]:
    chance = np.random.default_rng(seed)
    return {
        "speed": chance.uniform(0.5, 5.0, k),
        "direction": chance.uniform(-math.pi, math.pi, k),
        "elevation": chance.choice([0.0, 0.1, 0.9], k),
        "offset_left": chance.uniform(-0.3, 0.3, k),
        "offset_up": chance.uniform(-0.3, 0.3, k),
    }


def strike_of(aims: dict[str, np.ndarray], i: int, **cue) -> Strike:
    return Strike(**{name: float(values[i]) for name, values in aims.items()}, **cue)


# Bits


@pytest.mark.parametrize("squirt", ["end-mass", "alciatore", "none"])
@pytest.mark.parametrize("physics", [{}, FLIES], ids=["on the cloth", "airborne"])
def test_each_shot_is_that_of_the_scene_with_its_strike(squirt, physics):
    cue = {"squirt": squirt, "cue_mass": 0.5, "tip_restitution": 0.8}
    scene = layout(Strike(speed=1.0, direction=0.0, **cue), **physics)
    aims = random_strokes(1, 12)
    batch = simulate_starts(scene, strokes=Strokes(**aims, ball="cue"), threads=2)
    for i in range(12):
        strike = strike_of(aims, i, **cue)
        assert_same(batch, i, simulate(moved(scene, strike)))
        assert batch.strokes.strike(i) == strike


def test_the_stroke_of_the_scene_itself_gives_the_shot_of_the_scene():
    strike = Strike(speed=2.5, direction=0.3, elevation=0.2, offset_left=0.2, offset_up=-0.1)
    scene = layout(strike)
    strokes = Strokes(2.5, 0.3, elevation=0.2, offset_left=0.2, offset_up=-0.1)
    batch = simulate_starts(scene, strokes=strokes)
    assert len(batch.status) == 1
    assert_same(batch, 0, simulate(scene))


def test_a_ball_without_a_strike_is_struck_by_the_usual_cue():
    batch = simulate_starts(layout(), strokes=Strokes([1.0, 2.0], 0.3))
    for i in range(2):
        assert_same(batch, i, simulate(moved(layout(), strike_of(batch.strokes.aims._asdict(), i))))


def test_places_of_all_balls_may_be_given_too():
    scene, chance = layout(), np.random.default_rng(2)
    places = scene.positions[:, :2] + chance.uniform(-0.05, 0.05, (4, 3, 2))
    aims = random_strokes(3, 4)
    batch = simulate_starts(scene, places, strokes=Strokes(**aims))
    for i in range(4):
        assert_same(batch, i, simulate(moved(scene, strike_of(aims, i), places[i])))
    # One stroke from all places, and all strokes from one place.
    batch = simulate_starts(scene, places, strokes=Strokes(2.0, 0.1))
    assert_same(batch, 3, simulate(moved(scene, Strike(speed=2.0, direction=0.1), places[3])))
    batch = simulate_starts(scene, places[2], strokes=Strokes(**aims))
    assert_same(batch, 3, simulate(moved(scene, strike_of(aims, 3), places[2])))


@pytest.mark.parametrize("places", [False, True])
def test_other_balls_move_as_in_the_scene(places):
    spun = ball((1.4, 0.4), (1.0, 0.3), angular_velocity=(3.0, 9.0, 20.0))
    scene = scene_of(
        ball((0.6, 0.6)), spun, ball((1.0, 0.9), (0.2, 0.1)), table=POCKET_TABLE, preset="pool"
    )
    struck = ball((0.6, 0.6), strike=Strike(speed=2.0, direction=0.1))
    del struck["velocity"]
    others = [{**spun}, ball((1.0, 0.9), (0.2, 0.1))]
    expected = scene_of(struck, *others, table=POCKET_TABLE, preset="pool")
    arrays = [scene.positions] if places else []
    batch = simulate_starts(scene, *arrays, strokes=Strokes(2.0, 0.1))
    assert_same(batch, 0, simulate(expected))


def test_strokes_keep_their_values_when_an_array_changes():
    speeds = np.array([1.0, 2.0])
    strokes = Strokes(speeds, 0.1)
    speeds[:] = 3.0
    assert strokes.drawn(layout()).speed.tolist() == [1.0, 2.0]


def test_no_strokes_give_an_empty_batch():
    assert len(simulate_starts(layout(), strokes=Strokes([], 0.1)).status) == 0


# Noise

NOISE = {"speed": 0.1, "direction": 0.01, "elevation": 0.02, "offset_left": 0.03, "offset_up": 0.04}


def drawn(k: int = 4_000, **fields) -> DrawnStrokes:
    aims = {"speed": np.full(k, 2.0), "direction": 0.3, "elevation": 0.4, "offset_up": -0.1}
    return Strokes(**{**aims, "noise": NOISE, "seed": 7, **fields}).drawn(layout())


def test_errors_have_the_standard_deviations_that_are_asked_for():
    found, exact = drawn(), (2.0, 0.3, 0.4, 0.0, -0.1)
    for values, mean, deviation in zip(found.aims, exact, NOISE.values(), strict=True):
        assert abs(values.mean() - mean) < 4.0 * deviation / math.sqrt(4_000)
        assert values.std() == pytest.approx(deviation, rel=4.0 / math.sqrt(8_000))
    correlations = np.corrcoef(found.aims) - np.eye(5)
    assert np.abs(correlations).max() < 4.0 / math.sqrt(4_000)
    assert found.draws.tolist() == [1] * 4_000


def test_noise_of_a_shot_depends_on_the_seed_and_its_index_alone():
    # Half of the level strokes are drawn again.
    many, few = drawn(elevation=0.0), drawn(100, elevation=0.0)
    for name in (*FIELDS, "draws"):
        assert np.array_equal(getattr(many, name)[:100], getattr(few, name)), name
    assert many.draws.max() > 5
    # Nor do they depend on the other strokes.
    raised = drawn(elevation=np.repeat([0.4, 0.0], 2_000))
    for name in (*FIELDS, "draws"):
        assert np.array_equal(getattr(many, name)[2_000:], getattr(raised, name)[2_000:]), name
    assert not np.array_equal(few.speed, drawn(100, elevation=0.0, seed=8).speed)
    assert np.all(drawn(noise={"speed": 0.1}).direction == 0.3)


def test_impossible_strokes_are_drawn_again():
    found = drawn(elevation=0.0, offset_up=-0.51, noise={"elevation": 0.01, "offset_up": 0.01})
    assert found.elevation.min() >= 0.0
    assert np.hypot(found.offset_left, found.offset_up).max() <= 0.6 / math.sqrt(1.36)
    # A half of a normal distribution.
    assert found.elevation.mean() == pytest.approx(0.01 * math.sqrt(2.0 / math.pi), rel=0.05)
    expected = 1.0 / (0.5 * 0.5 * (1.0 + math.erf((0.6 / math.sqrt(1.36) - 0.51) / 0.014142)))
    assert found.draws.mean() == pytest.approx(expected, rel=0.1)


def test_a_direction_may_pass_a_whole_turn():
    found = drawn(direction=2.0 * math.pi, noise={"direction": 0.01})
    assert found.draws.max() == 1
    errors = (found.direction + math.pi) % (2.0 * math.pi) - math.pi
    assert errors.std() == pytest.approx(0.01, rel=0.05)


def test_noise_that_leaves_hardly_any_stroke_possible_is_refused():
    with pytest.raises(GhostballError, match=r"1000 draws for shot 0 gave none. Lower the noise"):
        drawn(1, noise={"offset_up": 1e9})


@pytest.mark.compiled
def test_the_bits_do_not_depend_on_the_threads():
    strokes = Strokes(np.full(600, 3.0), 0.2, noise=NOISE, seed=1)
    one, two = (simulate_starts(layout(), strokes=strokes, threads=n) for n in (1, 2))
    assert np.array_equal(one.rest_positions, two.rest_positions)
    assert np.array_equal(one.pocketed_at, two.pocketed_at, equal_nan=True)
    assert len(np.unique(one.rest_times)) == 600


CUT = scene_of(
    ball((1.20, 0.635), id="cue"),
    ball((1.80, 0.9), id="object"),
    table=POCKET_TABLE,
    preset="pool",
)
AIM, SPEED = math.radians(23.7), 2.5
ERRORS = {"speed": 0.1, "direction": math.radians(0.4), "offset_left": 0.05}


def share_of_single_shots(count: int, wider: float = 1.0) -> float:
    """Return the share of made cuts in single shots, whose errors are drawn by other code."""
    chance, made = random.Random(3), 0
    for _ in range(count):
        strike = Strike(
            speed=SPEED + chance.gauss(0.0, ERRORS["speed"]),
            direction=AIM + wider * chance.gauss(0.0, ERRORS["direction"]),
            offset_left=chance.gauss(0.0, ERRORS["offset_left"]),
        )
        shot = scene_of(
            {"id": "cue", "position": (1.20, 0.635), "strike": strike},
            ball((1.80, 0.9), id="object"),
            table=POCKET_TABLE,
            preset="pool",
        )
        made += bool(simulate(shot, record="events").outcomes("cue").pocketed[1] == 3)
    return made / count


@pytest.mark.compiled
def test_the_chance_of_a_cut_agrees_with_single_shots():
    strokes = Strokes(np.full(10_000, SPEED), AIM, noise=ERRORS, seed=1)
    chance = np.mean(simulate_starts(CUT, strokes=strokes).pocketed[:, 1] == 3)
    assert 0.3 < chance < 0.9  # otherwise errors of the aim would hardly matter
    error = math.sqrt(chance * (1.0 - chance) * (1.0 / 10_000 + 1.0 / 1_000))
    assert abs(share_of_single_shots(1_000) - chance) < 4.0 * error
    # The test would notice errors that are half as wide.
    assert abs(share_of_single_shots(1_000, wider=0.5) - chance) > 4.0 * error


# Refusals


def test_the_rules_are_those_of_a_strike():
    values = {
        "speed": [-1.0, 0.0, 1e-51, 1e-50, 2.0, 1e49, 1.1e49, math.nan],
        "direction": [-6.3, -2.0 * math.pi, 0.0, 2.0 * math.pi, 6.3, math.inf],
        "elevation": [-1e-9, -0.0, 0.5, 0.5 * math.pi, math.nextafter(0.5 * math.pi, 0.0)],
        "offset_left": [0.0, -0.3, 0.6, 1e300],
        "offset_up": [0.0, 0.42, 0.51, 0.6 / math.sqrt(1.36), -1.0],
    }
    combined = list(product(*values.values()))
    chance = random.Random(5)
    for friction in (0.6, 1e50):
        cue = Strike(speed=1.0, direction=0.0, tip_friction=friction)
        chosen = chance.sample(combined, 500)
        found = are_valid(cue, Aims(*np.array(chosen).T))
        assert 0 < found.sum() < 500
        for aim, valid in zip(chosen, found, strict=True):
            fields = dict(zip(values, aim, strict=True))
            try:
                Strike(**fields, tip_friction=friction)
            except SceneError:
                assert not valid, fields
            else:
                assert valid, fields


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"speed": "fast"}, "`strokes.speed` must be numbers, got 'fast'"),
        ({"speed": [[1.0]]}, r"`strokes.speed` must be one-dimensional, got shape \(1, 1\)"),
        ({"direction": [0.1, math.nan]}, "`strokes.direction` must be finite, got nan for shot 1"),
        ({"speed": [1.0, 2.0], "direction": [0.1] * 3}, "one number per shot.*; got 2 of `speed`"),
        ({"speed": [1.0, -2.0]}, "`strokes` of shot 1: `speed` must be greater than 0, got -2.0"),
        ({"direction": [0.1, 90.0]}, "of shot 1: `direction` must be an angle .* 1.57079633"),
        ({"offset_left": [0.0, 1.5]}, "of shot 1: .* must hit the ball, got offset_left 1.5"),
        ({"offset_up": [0.0, -0.6]}, "of shot 1: .* within the miscue limit"),
        ({"elevation": [0.0, -0.1]}, "of shot 1: `elevation` .* start below the cloth"),
        ({"ball": 3}, "`strokes.ball` must be the index of a ball, 0 to 2, or its id, got 3"),
        ({"ball": "eight"}, "`strokes.ball` must be the index .* got 'eight'"),
        ({"noise": 0.1}, "`noise` must be a dict, got float"),
        ({"noise": {"angle": 0.1}}, "`noise` must name fields of a stroke, .* got 'angle'"),
        (
            {"noise": {"speed": -0.1}},
            r'`noise\["speed"\]` must be a number of at least 0, got -0.1',
        ),
        ({"noise": {"speed": math.nan}}, "must be a number of at least 0, got nan"),
        ({"noise": {"speed": [0.1, 0.2]}}, r"must be a number of at least 0, got \[0.1, 0.2\]"),
        ({"seed": -1}, "`seed` must be a whole number of at least 0, got -1"),
        ({"seed": 1.5}, "`seed` must be a whole number of at least 0, got 1.5"),
    ],
)
def test_strokes_are_refused_that_no_cue_can_play(fields, message):
    with pytest.raises(GhostballError, match=message) as caught:
        simulate_starts(layout(), strokes=Strokes(**{"speed": 2.0, "direction": 0.1, **fields}))
    assert "\n" not in str(caught.value)


def test_arguments_that_do_not_fit_strokes_are_refused():
    scene, stroke = layout(), Strokes([1.0, 2.0], 0.1)
    with pytest.raises(GhostballError, match="`strokes` must be Strokes, got dict"):
        simulate_starts(scene, strokes={"speed": 1.0})
    for name in ("velocities", "angular_velocities"):
        with pytest.raises(GhostballError, match="must not be given with `strokes`"):
            simulate_starts(scene, strokes=stroke, **{name: scene.velocities})
    with pytest.raises(GhostballError, match=r"one number per shot.* for 3 shots"):
        simulate_starts(scene, np.stack([scene.positions] * 3), strokes=stroke)


def test_a_ball_in_the_air_is_not_struck():
    scene = layout(**FLIES)
    places = np.stack([scene.positions] * 2)
    places[1, 0, 2] += 0.1
    with pytest.raises(SceneError, match=r"`balls\[0\].position` in shot 1 must have z = 0.028 m"):
        simulate_starts(scene, places, strokes=Strokes(1.0, 0.1))


def test_a_stroke_that_a_scene_would_be_refused_for_is_refused():
    rolling = Strike(speed=1.0, direction=0.0, offset_up=0.4, squirt="none")
    rolls = scene_of({"position": (0.6, 0.6), "strike": rolling}, ball((1.6, 0.635)))
    with pytest.raises(SceneError, match=r"`balls\[0\].angular_velocity` in shot 1 .*\"rolling\""):
        simulate_starts(rolls, strokes=Strokes(2.0, 0.0, offset_up=[0.4, 0.3]))


# The next shot


def test_the_next_scene_of_a_batch_is_that_after_the_result():
    aims = random_strokes(9, 30)
    scene = layout()
    batch = simulate_starts(scene, strokes=Strokes(**aims))
    shots = [moved(scene, strike_of(aims, i)) for i in range(30)]
    many = simulate_many([*shots, CUT])
    for i, shot in enumerate(shots):
        result = simulate(shot, record="events")
        expected = Scene.after(result)
        assert batch.scene(i) == many.scene(i) == expected
        assert np.array_equal(batch.gone[i], result.gone)
    assert batch.gone.any()
    assert batch.scene(0).name == "test.2"
    change = {"cue": {"strike": Strike(speed=1.0, direction=0.5)}}
    kept = int(np.flatnonzero(~batch.gone[:, 0])[0])
    following = batch.scene(kept, name="next", changes=change, title="Next")
    assert (following.name, following.title) == ("next", "Next")
    assert following.balls[0].strike == change["cue"]["strike"]
    assert len(many.scene(30).balls) == 2


def test_a_next_scene_that_there_is_not_is_refused():
    batch = simulate_starts(layout(), strokes=Strokes([1.0, 2.0], 0.1), max_events=1)
    for wrong in (2, -1, True, 0.0):
        with pytest.raises(GhostballError, match="`i` must be the index of a shot, 0 to 1, got"):
            batch.scene(wrong)
    with pytest.raises(SceneError, match=r"shot 1: .* must be at rest, .* EVENT_LIMIT"):
        batch.scene(1)
    with pytest.raises(GhostballError, match="without shots has no next scene"):
        simulate_many([]).scene(0)


def test_a_frame_has_the_strokes():
    pytest.importorskip("polars")
    batch = simulate_starts(layout(), strokes=Strokes([1.0, 2.0], 0.1, noise={"direction": 0.01}))
    frame = batch.to_frame(cue="cue")
    for name in FIELDS:
        assert np.array_equal(frame[name], getattr(batch.strokes, name))
    assert frame["draws"].to_list() == [1, 1]
